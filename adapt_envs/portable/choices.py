"""What a scene can be made of: bodies, locked joints and grounds, from the rows of the suite."""

from dataclasses import dataclass

from adapt_envs.suite import SUITE, TaskSpec


@dataclass(frozen=True)
class Choice:
    """One entry of a list that people choose from.

    Attributes:
        row: the row of the suite that it comes from; only its body, its lock or its ground counts.
        words: what it is, for people.
    """

    row: TaskSpec
    words: str


def _words(row: TaskSpec, preposition: str) -> str:
    """What stands behind the preposition in a row's summary: "Walk with stiff elbows." is "stiff elbows"."""
    return row.summary.partition(f" {preposition} ")[2].rstrip(".").partition(",")[0]


PLAIN = "plain"
"""The name of the plain body, and of no lock."""
_WALK = SUITE["Walk"]
BODIES: dict[str, Choice] = {PLAIN: Choice(_WALK, "as in the motions")} | {
    row.morphology: Choice(row, _words(row, "with"))
    for row in SUITE.values()
    if isinstance(row.morphology, str) and row.base == "walk"
}
"""Body shapes by name."""
LOCKS: dict[str, Choice] = {PLAIN: Choice(_WALK, "all joints move")} | {
    row.locked[0]: Choice(row, _words(row, "with")) for row in SUITE.values() if row.locked and row.base == "walk"
}
"""Locked joints by the name of the place."""
GROUNDS: dict[str, Choice] = {
    "flat": Choice(_WALK, "flat and endless"),
    "ice": Choice(SUITE["IceWalk"], _words(SUITE["IceWalk"], "on")),
    "hills": Choice(SUITE["TerrainHills"], _words(SUITE["TerrainHills"], "on")),
    "blocks": Choice(SUITE["Obstacles"], _words(SUITE["Obstacles"], "between")),
}
"""Grounds by name."""
