"""Plain values of a YAML file, each as wanted or refused with a sentence that says where it stands."""

import inspect
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

LABEL = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
"""What names folders and files."""
LARGEST_SEED = 2**32 - 1
"""NumPy's."""


def mapping(where: str, value: Any, valid: Sequence[str] | None = None) -> dict[str, Any]:
    """A mapping with text keys, of the `valid` ones where they are given.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, dict):
        raise ValueError(f"{where} is {value!r}, expected a mapping")
    unknown = [key for key in value if not isinstance(key, str) or (valid is not None and key not in valid)]
    if unknown:
        raise ValueError(f"{where} has the unknown key {unknown[0]!r}; valid are: {', '.join(valid or ('words',))}")
    return value


def number(where: str, value: Any, least: float = 0.0) -> float:
    """A number, at least `least`.

    Raises:
        ValueError: for anything else, also for what YAML reads as text.
    """
    if isinstance(value, str) and re.fullmatch(r"[-+\d.]+[eE][-+]?\d+", value):
        raise ValueError(f"{where} is text to YAML: write {float(value):.1f} instead of {value}")
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value < float("inf"):
        raise ValueError(f"{where} is {value!r}, expected a number of at least {least:g}")
    return value


def whole(where: str, value: Any, least: int = 0) -> int:
    """A whole number, at least `least`; 2.0e+6 is one.

    Raises:
        ValueError: for anything else.
    """
    found = number(where, value, least)
    if found != int(found):
        raise ValueError(f"{where} is {value!r}, expected a whole number of at least {least}")
    return int(found)


def one_of(where: str, value: Any, valid: Sequence[int]) -> int:
    """A whole number that is among the `valid` ones.

    Raises:
        ValueError: for anything else.
    """
    found = whole(where, value)
    if found not in valid:
        raise ValueError(f"{where} is {value!r}, expected one of {', '.join(map(str, valid))}")
    return found


def seeds(where: str, value: Any) -> tuple[int, ...]:
    """A list of different whole numbers.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, list) or not value:
        raise ValueError(f"{where} is {value!r}, expected a list of whole numbers, such as [0, 1]")
    found = tuple(whole(f"a seed in {where}", one) for one in value)
    if max(found) > LARGEST_SEED:
        raise ValueError(f"a seed in {where} is {max(found)}, expected at most {LARGEST_SEED}")
    if len(set(found)) < len(found):
        raise ValueError(f"{where} is {value!r}: a seed stands there twice")
    return found


def label(where: str, value: Any) -> str:
    """A word that can name a folder.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, str) or not LABEL.fullmatch(value):
        raise ValueError(f"{where} is {value!r}, expected a word of letters, digits, dots, dashes and underscores")
    return value


def load_class(where: str, name: Any, kind: type) -> Any:
    """Import a class of a kind by its dotted name.

    Raises:
        ValueError: if there is no such module or class. One that its package exports under a shorter name is named.
    """
    module, _, attribute = str(name).rpartition(".")
    try:
        found = getattr(import_module(module), attribute)
        if not isinstance(found, type) or not issubclass(found, kind):
            raise ValueError(f"it is no {kind.__name__}")
        return found
    except (ImportError, AttributeError, ValueError) as error:
        package = module.partition(".")[0]
        shorter = getattr(sys.modules.get(package), attribute, None)
        moved = module != package and isinstance(shorter, type) and issubclass(shorter, kind)
        hint = f"; write {package}.{attribute}" if moved else f" ({error})"
        raise ValueError(f"{where}: no class {name!r}{hint}") from error


def arguments_of(cls: type) -> tuple[str, ...]:
    """Names of a class's constructor arguments, its bases' as well where it hands `**kwargs` on."""
    names: dict[str, None] = {}
    for base in inspect.getmro(cls):
        parameters = inspect.signature(base).parameters.values()
        names.update((p.name, None) for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY))
        if not any(p.kind is p.VAR_KEYWORD for p in parameters):
            break
    return tuple(name for name in names if name != "self")
