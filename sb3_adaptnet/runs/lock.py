"""One lock for each folder that a process works in: a training, a sweep, or a run of one."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

LOCK = ".lock"
"""Name of the file that is locked."""


def lock_of(folder: Path) -> FileLock:
    """The lock that says a process is at work in a folder; it falls with its process, however that ends.

    Within the process that holds it, it can be taken again: a sweep's run trains in the folder that it holds.
    """
    return FileLock(folder.resolve() / LOCK, is_singleton=True)


def is_locked(folder: Path) -> bool:
    """Whether a process is at work in a folder, this one included."""
    lock = lock_of(folder)
    if lock.is_locked or not Path(lock.lock_file).is_file():
        return lock.is_locked
    try:
        with lock.acquire(timeout=0):
            return False
    except Timeout:
        return True


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Keep other processes from training in a folder, which is created.

    Raises:
        ValueError: if another process is at work there.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lock = lock_of(folder)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise ValueError(f"another process is at work in {folder}; stop it, or choose another folder") from None
    try:
        yield
    finally:
        lock.release()


def clear(folder: Path) -> None:
    """Remove all that is in a folder that is held, but for its lock."""
    for path in folder.iterdir():
        if path.name != LOCK:
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
