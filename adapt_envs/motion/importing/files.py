"""Opening files that users bring: every way in which one can be unfit, named in one sentence."""

from pathlib import Path

from adapt_envs.motion.clip import MotionError

MAX_BYTES = 128 * 2**20
"""Largest file that is read: twenty minutes of motion capture at 120 Hz."""


def read_text(path: Path, suffixes: tuple[str, ...], max_bytes: int = MAX_BYTES) -> str:
    """Text of a file, after looking at its kind, size and first bytes.

    Args:
        path: the file.
        suffixes: the extensions it may have, in lower case with the dot.
        max_bytes: the largest size that is read.

    Raises:
        MotionError: if it is missing, a folder, of another extension, empty, too large, binary or unreadable.
    """
    if not path.exists():
        raise MotionError(f"{path}: no such file")
    if not path.is_file():
        raise MotionError(f"{path}: not a regular file")
    if path.suffix.lower() not in suffixes:
        raise MotionError(f"{path}: extension {path.suffix or '(none)'} is not among {', '.join(suffixes)}")
    try:
        size = path.stat().st_size
        if size > max_bytes:
            mib, most = size / 2**20, max_bytes / 2**20
            raise MotionError(f"{path}: the file is too large, {mib:.0f} MiB; at most {most:.0f} MiB are read")
        content = path.read_bytes()
    except OSError as error:
        raise MotionError(f"{path}: cannot be read ({error.strerror})") from None
    return _decoded(path, content)


def _decoded(path: Path, content: bytes) -> str:
    if not content.strip():
        raise MotionError(f"{path}: the file is empty")
    if b"\0" in content:
        line = content[: content.index(0)].count(b"\n") + 1
        raise MotionError(f"{path}: line {line}: a zero byte; this is a binary file, not text")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise MotionError(f"{path}: line {line}: byte 0x{content[error.start]:02x} is not text (UTF-8)") from None
