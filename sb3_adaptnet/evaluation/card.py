"""Figures in the card of a weight file, with the command that finds them again."""

import shlex
from pathlib import Path
from typing import Any

from sb3_adaptnet.evaluation.figures import Figures
from sb3_adaptnet.hub import is_address
from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.checkpoint import resolve
from sb3_adaptnet.weights.weight_file import read_weights

TRAINING_MEANS = "means_of_last_rollouts"
"""Entry of a card's `training`: what training itself reported at its end, with exploration, in the worlds it saw."""
_UNLABELLED = "metrics"
"""Where cards held these means before, as if they were an evaluation."""


def eval_command(policy: str, figures: Figures, **options: str | None) -> str:
    """The command that finds figures again in the folder of the weights, or anywhere for shipped ones.

    Args:
        policy: name or file of what was measured.
        figures: what was found.
        **options: values of further options by their names, such as `base`; None leaves one out. Files are named
            without their folders, which mean nothing elsewhere; addresses stay.
    """
    words = ["adaptnet", "eval", Path(policy).name, "--seed", str(figures.seed), "--seconds", f"{figures.seconds:g}"]
    for name, value in options.items():
        if value is not None:
            words += [f"--{name}", value if name == "env" or is_address(value) else Path(value).name]
    return shlex.join(words)


def evaluation_block(figures: Figures, command: str) -> dict[str, Any]:
    """The entry `evaluation` of a card.

    Returns:
        `command`, `seed`, `seconds` (simulated), and `figures`: the other fields of `adaptnet eval --json`.
    """
    values = figures.as_dict()
    return {"command": command, "seed": values.pop("seed"), "seconds": values.pop("seconds"), "figures": values}


def write_evaluation(policy: str | Path, figures: Figures, command: str) -> Path:
    """Write figures into the card of a weight file; its weights and their hash stay as they are.

    A card written before cards had evaluations is brought up to date: its training's means get the name that says so.

    Args:
        policy: name of a shipped file, or a path.
        figures: what the file's policy was measured to do.
        command: what finds them again.

    Returns:
        The file.

    Raises:
        CheckpointError: if the file is missing, damaged or foreign.
    """
    file = resolve(policy)
    card = read_weights(file)[1]
    entries: dict[str, Any] = {"evaluation": evaluation_block(figures, command)}
    training = card.get("training", {})
    if _UNLABELLED in card and "ppo" in training:  # else it is the user's own entry
        entries |= {"training": {**training, TRAINING_MEANS: card[_UNLABELLED]}, _UNLABELLED: None}
    amend_card(file, **entries)
    return file
