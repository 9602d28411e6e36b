"""The optional package `onnx`."""

from importlib import import_module
from typing import Any


def onnx_package() -> Any:
    """The package `onnx`, which has no type stubs for its generated classes, hence `Any`.

    Raises:
        ValueError: if it is not installed.
    """
    try:
        return import_module("onnx")
    except ImportError:
        raise ValueError("writing ONNX needs the package onnx: pip install 'adaptnet-gym[onnx]'") from None
