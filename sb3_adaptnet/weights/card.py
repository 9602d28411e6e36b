"""What a weight file's card says, and adding to the card of one that exists; its weights stay as they are."""

from pathlib import Path
from typing import Any

from sb3_adaptnet.weights.checkpoint import resolve
from sb3_adaptnet.weights.weight_file import read_weights, replace_card

FIXED = ("format", "hash", "kind", "observation_version", "architecture", "base", "method", "shape")
"""Entries that say what the weights are: they belong to them."""


def amend_card(file: Path, **entries: Any) -> dict[str, Any]:
    """Write entries into a card: inside the weight file and in the `.json` beside it, each whole or not at all.

    Args:
        file: the weight file.
        **entries: JSON values; None takes an entry away.

    Returns:
        The whole card.

    Raises:
        CheckpointError: if the file is missing, damaged or foreign.
        ValueError: for an entry that belongs to the weights.
    """
    fixed = [name for name in entries if name in FIXED]
    if fixed:
        raise ValueError(f"the card's entry {fixed[0]!r} belongs to the weights of {str(file)!r} and cannot change")
    card = read_weights(file)[1]
    amended = {name: value for name, value in (card | entries).items() if value is not None or name not in entries}
    replace_card(file, amended)
    return amended


def trained_in(policy: str) -> tuple[str, str | None]:
    """Environment that a weight file's card names, and the clip that it was trained on, None if it names none.

    Raises:
        ValueError: if the card names no environment.
    """
    file = resolve(policy)
    card = read_weights(file)[1]
    environment = card.get("environment")
    if not isinstance(environment, str):
        raise ValueError(f"{policy!r} does not say what it was trained in; name an environment with --env")
    if ":" in environment:  # gymnasium would import a module because a file says so
        raise ValueError(
            f"{policy!r} was trained in {environment!r}, a module's own; name it with --env, if you trust it"
        )
    motion = card.get("motion")
    beside = file.with_name(motion) if motion is not None and Path(motion).name == motion else None
    return environment, str(beside) if beside is not None and beside.is_file() else motion
