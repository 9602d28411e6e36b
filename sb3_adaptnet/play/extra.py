"""The optional packages of the view in the browser, None where they are not installed: `pip install viser` brings all.

They have no type stubs that say what they need, hence `Any`.
"""

from importlib import import_module
from typing import Any


def _optional(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        return None


viser, trimesh, pil_image = (_optional(name) for name in ("viser", "trimesh", "PIL.Image"))
