"""Entries of tables by name: a field of a row is a name, or the thing itself."""

from collections.abc import Mapping
from typing import TypeVar

Entry = TypeVar("Entry")


def entry(kind: str, table: Mapping[str, Entry], value: str | Entry) -> Entry:
    """`value` itself, or the entry of `table` that it names.

    Raises:
        ValueError: if nothing is named so, listing the names; `kind` says what was looked for.
    """
    if not isinstance(value, str):
        return value
    if value not in table:
        raise ValueError(f"no {kind} is named {value!r}; the names are {', '.join(table)}")
    return table[value]
