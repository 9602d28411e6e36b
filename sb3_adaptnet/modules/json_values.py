"""Dataclasses of sizes and choices that go into a file's card as JSON, and come back."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, Self, cast


class JsonValues:
    """What a frozen dataclass inherits to go through JSON."""

    def to_dict(self) -> dict[str, Any]:
        """The fields as JSON values."""
        return asdict(cast(Any, self))

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """Inverse of `to_dict`, also after a passage through JSON: lists become tuples again.

        Raises:
            TypeError: for a name that is not a field, or a missing one.
        """
        return cls(**{name: _with_tuples(value) for name, value in values.items()})


def _with_tuples(value: Any) -> Any:
    return tuple(_with_tuples(part) for part in value) if isinstance(value, list | tuple) else value
