"""What a weight file's card says, and adding to the card of one that exists; its weights stay as they are."""

from collections.abc import Mapping
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
        ValueError: if the card names no environment, or one that is a module's own.
    """
    file = resolve(policy)
    card = read_weights(file)[1]
    environment, motion = environment_of(card, policy), card.get("motion")
    if motion is None:
        return environment, None
    if not isinstance(motion, str):
        raise ValueError(f"the card of {policy!r} says that the motion is {motion!r}; name an environment with --env")
    beside = file.with_name(Path(motion).name)  # whatever path it had where it was trained
    return environment, str(beside) if beside.is_file() else motion


def environment_of(card: Mapping[str, Any], file: str) -> str:
    """Environment that the card of a file names.

    Raises:
        ValueError: if it names none, or a module's own: gymnasium would import the module because a file says so.
    """
    environment = card.get("environment")
    if not isinstance(environment, str):
        raise ValueError(f"{file!r} does not say what it was trained in; name an environment with --env")
    if ":" in environment:
        raise ValueError(
            f"{file!r} was trained in {environment!r}, a module's own; name it with --env, if you trust it"
        )
    return environment
