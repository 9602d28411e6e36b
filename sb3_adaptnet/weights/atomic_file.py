"""Files that appear whole or not at all, whenever the process is killed."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO


def write_atomically(path: Path, write: Callable[[BinaryIO], Any]) -> None:
    """Write a file so that at any moment either the old or the new content is there.

    The content goes into a file beside it, which is flushed to disk and then renamed; a failed write leaves nothing.

    Args:
        path: the file; its folder must exist.
        write: writes the content into a binary stream.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.part")  # two processes may write the same file
    try:
        with part.open("wb") as stream:
            write(stream)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
