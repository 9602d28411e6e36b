"""Changes to an entry of the zoo."""

from collections.abc import Mapping
from typing import Any


def merged(entry: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """An entry with changes: mappings change key by key, everything else is replaced.

    A schedule, a mapping from samples to numbers, is replaced as a whole. A mapping changes the callbacks of a list by
    their names, and leaves the rest of the list.

    Args:
        entry: what is changed; it stays as it is.
        changes: key -> new value, or what changes below the key.

    Raises:
        ValueError: for a callback that the entry does not have.
    """
    return {**entry, **{key: _changed(key, entry.get(key), new) for key, new in changes.items()}}


def _changed(key: str, old: Any, new: Any) -> Any:
    if not _has_words(new):
        return new
    if _has_words(old):
        return merged(old, new)
    if isinstance(old, list):
        return _changed_callbacks(key, old, new)
    return new


def _has_words(value: Any) -> bool:
    return isinstance(value, Mapping) and all(isinstance(key, str) for key in value)


def _changed_callbacks(key: str, entries: list[Any], changes: Mapping[str, Any]) -> list[Any]:
    by_name = {next(iter(entry)) if isinstance(entry, Mapping) else entry: entry for entry in entries}
    for name, new in changes.items():
        if name not in by_name:
            raise ValueError(f"{key}: there is no {name!r} to change; there are: {', '.join(map(str, by_name))}")
        old = by_name[name]
        by_name[name] = {name: _changed(name, old[name] if isinstance(old, Mapping) else {}, new)}
    return list(by_name.values())
