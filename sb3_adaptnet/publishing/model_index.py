"""The figures of a card as the Hub's evaluation block, `model-index`."""

import shlex
from collections.abc import Mapping
from typing import Any

from sb3_adaptnet.evaluation.report import ROWS

_NOT_ITS_OWN = ("clip_", "base_")
"""Figures that begin so describe the motion or the base, not the policy."""


def model_index(name: str, card: Mapping[str, Any]) -> list[dict[str, Any]] | None:
    """One result, with every figure that is a number; None for a card without an evaluation.

    Args:
        name: of the model.
        card: the weight file's card.
    """
    block, environment = card.get("evaluation"), card.get("environment")
    if not block or not environment:
        return None
    measured, figures = shlex.split(block["command"]), block["figures"]
    if "--env" in measured:
        environment = measured[measured.index("--env") + 1]
    own = [field for _, field, _ in ROWS if not field.startswith(_NOT_ITS_OWN)]
    numbers = {field: figures[field] for field in own if type(figures.get(field)) in (int, float)}
    result = {
        "task": {"type": "reinforcement-learning", "name": "reinforcement-learning"},
        "dataset": {"name": environment, "type": environment},
        "metrics": [
            {"type": field, "value": value, "name": field.replace("_", " ")} for field, value in numbers.items()
        ],
    }
    return [{"name": name, "results": [result]}]
