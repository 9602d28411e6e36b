"""Where the data files are: inside an installed wheel, or at the root of a checkout."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def asset_path(name: str) -> Path:
    """Path of a data file or folder of `assets/`.

    Args:
        name: path relative to `assets/`, such as `"humanoid.xml"` or `"motions"`.

    Returns:
        The path in the installed package if it is there, else in the checkout.

    Raises:
        FileNotFoundError: if neither holds the file.
    """
    folders = (_PACKAGE / "assets", _PACKAGE.parent / "assets")
    for folder in folders:
        if (folder / name).exists():
            return folder / name
    raise FileNotFoundError(f"asset {name!r} is neither in {folders[0]} nor in {folders[1]}: reinstall the package")
