"""The optional package that speaks to the Hub."""

from importlib import import_module
from typing import Any


def hub_library() -> Any:
    """The package `huggingface_hub`; imported when it is needed, because it reads its settings then and takes a while.

    Raises:
        ValueError: if it is not installed.
    """
    try:
        for part in ("constants", "errors"):  # the package loads its modules when they are first asked for
            import_module(f"huggingface_hub.{part}")
        return import_module("huggingface_hub")
    except ImportError as error:
        raise ValueError(f"the Hub needs an optional package ({error}): pip install 'adaptnet-gym[hub]'") from error
