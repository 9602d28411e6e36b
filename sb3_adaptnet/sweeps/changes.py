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
        ValueError: for a callback that the entry does not have, or has twice.
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
    names = [next(iter(entry)) if isinstance(entry, Mapping) else entry for entry in entries]
    for name in changes:
        if name not in names:
            raise ValueError(f"{key}: there is no {name!r} to change; there are: {', '.join(map(str, names))}")
        if names.count(name) > 1:
            raise ValueError(f"{key}: {name!r} stands there {names.count(name)} times; give the whole list")
    return [
        {name: _changed(name, entry[name] if isinstance(entry, Mapping) else {}, changes[name])}
        if name in changes
        else entry
        for name, entry in zip(names, entries, strict=True)
    ]
