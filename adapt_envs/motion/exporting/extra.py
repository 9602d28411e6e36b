"""The optional packages that write glTF."""

from importlib import import_module
from typing import Any

PACKAGES = ("pygltflib", "trimesh")


def gltf_packages() -> tuple[Any, Any]:
    """The packages `pygltflib`, which holds and writes glTF files, and `trimesh`, which makes spheres and capsules.

    Raises:
        ValueError: if one is not installed.
    """
    try:
        pygltflib, trimesh = (import_module(name) for name in PACKAGES)
    except ImportError as error:
        raise ValueError(f"glTF needs optional packages ({error}): pip install 'adaptnet-gym[motion]'") from error
    return pygltflib, trimesh
