"""Files that commands are asked to write."""

import os
from pathlib import Path


def check_output(path: str | Path, *suffixes: str) -> None:
    """Refuse a file that cannot be written, before the work that it is to hold.

    Args:
        path: the file.
        suffixes: extensions that it may have, such as ".png"; none for any.

    Raises:
        ValueError: for another extension, a folder, or a file in a folder that does not exist or is read-only.
    """
    file = Path(path)
    if suffixes and file.suffix.lower() not in suffixes:
        raise ValueError(f"{path}: the extension must be {' or '.join(suffixes)}, not {file.suffix or 'none'}")
    if file.is_dir():
        raise ValueError(f"{path}: is a folder")
    if not file.absolute().parent.is_dir():
        raise ValueError(f"{path}: the folder {file.parent} does not exist")
    if not os.access(file.absolute().parent, os.W_OK):
        raise ValueError(f"{path}: the folder {file.parent} is read-only")
