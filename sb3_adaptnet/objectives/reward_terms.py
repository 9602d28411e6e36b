"""Objectives beyond the paper's two that environments reward themselves, by name."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

RewardTerm = Callable[[dict[str, Any]], NDArray[np.floating]]
"""PPO's local variables at a step to rewards (N,)."""


def environments_own(attribute: str, step: dict[str, Any]) -> NDArray[np.float32]:
    """Rewards (N,) of the transition just made, which the environments keep under this name.

    Raises:
        ValueError: if they have none.
    """
    env = step["env"]
    try:
        return np.asarray(env.get_attr(attribute), np.float32)
    except AttributeError as error:
        raise ValueError(f"the objective {attribute!r} needs environments with the attribute {attribute!r}") from error


TERMS: dict[str, RewardTerm] = {name: partial(environments_own, name) for name in ("footing", "clearance", "tracking")}
"""Reward terms by name: feet that stay where they stand, room to obstacles, and the clip's poses at its tempo."""
