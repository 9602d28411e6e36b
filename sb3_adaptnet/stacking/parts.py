"""What an adaptation changes of its base's world: fields of a row, so that two changes can be made at once."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import product
from pathlib import Path
from typing import Any

from adapt_envs import TaskSpec
from adapt_envs.registration import spec_of
from adapt_envs.suite import configured
from sb3_adaptnet.policies.loading import base_of_adaptation
from sb3_adaptnet.weights.card import trained_in
from sb3_adaptnet.weights.checkpoint import ADAPTATION, read_kind, resolve
from sb3_adaptnet.weights.shipped import pretrained_names
from sb3_adaptnet.weights.weight_file import read_weights

KINDS = {
    "motion": "style", "morphology": "body", "locked": "body", "friction": "ground", "terrain": "ground",
    "obstacles": "ground", "push": "push",
}  # fmt: skip
"""Field of a row -> what an adaptation is that was trained where this field differs from its base's."""
STACKED = (("style", "ground"), ("style", "body"), ("style", "push"), ("body", "ground"))
"""Kinds that are stacked, the first and the second."""
_WORDS = ("base", "summary", "terrain_seed")
"""Fields of a row that do not change the world that a policy is made for."""


@dataclass(frozen=True)
class Part:
    """An adaptation and what it was trained for.

    Attributes:
        name: its file's stem.
        file: the weight file.
        base: the file of its base.
        base_hash: hash of the base's weights, wherever the file lies.
        row: the base's world.
        changes: fields of the row that are otherwise in the adaptation's world, and their values.
        kind: style, body, ground or push.
    """

    name: str
    file: Path
    base: Path
    base_hash: str
    row: TaskSpec
    changes: dict[str, Any]
    kind: str

    @property
    def world(self) -> TaskSpec:
        """The adaptation's own world."""
        return replace(self.row, **self.changes)


@dataclass(frozen=True)
class Pair:
    """Two adaptations of one base, of different kinds."""

    first: Part
    second: Part

    @property
    def kinds(self) -> tuple[str, str]:
        """What the two are."""
        return self.first.kind, self.second.kind

    @property
    def world(self) -> TaskSpec:
        """The base's world with the changes of both: a style brings its motion and its speeds."""
        return replace(self.first.row, **(self.first.changes | self.second.changes))


def part_of(name_or_file: str | Path) -> Part:
    """What an adaptation changes.

    Args:
        name_or_file: name of a shipped adaptation, or a file.

    Raises:
        CheckpointError: if a file is missing or damaged, or its base is.
        ValueError: if it is a base, its card names no environment, or its world is the base's.
    """
    file = resolve(name_or_file)
    if read_kind(file) != ADAPTATION:
        raise ValueError(f"{str(name_or_file)!r} is a base; adaptations are stacked")
    base = base_of_adaptation(file)
    own, row = (_row(*trained_in(str(path))) for path in (file, base))
    names = [item.name for item in fields(TaskSpec) if item.name not in _WORDS]
    changes = {name: getattr(own, name) for name in names if getattr(own, name) != getattr(row, name)}
    kinds = [kind for name, kind in KINDS.items() if name in changes]
    if not kinds:
        raise ValueError(f"{str(name_or_file)!r} was trained in its base's own world; there is nothing to stack")
    return Part(file.stem, file, base, read_weights(base)[1]["hash"], row, changes, kinds[0])


def _row(environment: str, motion: str | None) -> TaskSpec:
    spec = spec_of(environment)
    if "task" not in spec.kwargs:
        raise ValueError(f"{environment} is not of this suite: what its adaptations change is not known")
    return configured(spec.kwargs["task"], {} if motion is None else {"motion": motion})


def pairs_of(names: Sequence[str] = ()) -> list[Pair]:
    """The pairs of adaptations that can be stacked: of one base, and of two kinds in `STACKED`.

    Args:
        names: names or files of adaptations; none takes all that ship.

    Raises:
        CheckpointError, ValueError: as `part_of`, or if two have one name, or if there is no pair.
    """
    chosen = names or [name for name in pretrained_names() if read_kind(name) == ADAPTATION]
    parts = [part_of(name) for name in chosen]
    twice = [name for name, count in Counter(part.name for part in parts).items() if count > 1]
    if twice:
        raise ValueError(f"two of these adaptations are named {twice[0]!r}; leave one out, or rename its file")
    pairs = [
        Pair(first, second)
        for kinds in STACKED
        for first, second in product(parts, parts)
        if (first.kind, second.kind) == kinds and first.base_hash == second.base_hash
    ]
    if not pairs:
        kinds = ", ".join(" + ".join(kinds) for kinds in STACKED)
        raise ValueError(f"no two of {', '.join(map(str, chosen))} have one base and are {kinds}")
    return pairs
