"""Objectives beyond the paper's two that environments reward themselves, by name."""

from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

RewardTerm = Callable[[dict[str, Any]], NDArray[np.floating]]
"""PPO's local variables at a step to rewards (N,)."""


def own_rewards(name: str, env: VecEnv) -> NDArray[np.float32]:
    """Rewards (N,) of the transition just made, which the environments keep under this name.

    Raises:
        ValueError: if they have none.
    """
    try:
        return np.asarray(env.get_attr(name), np.float32)
    except AttributeError as error:
        raise ValueError(f"the objective {name!r} needs environments with the attribute {name!r}") from error
    except ValueError as error:
        raise ValueError(f"the objective {name!r} cannot be had here: {error}") from error


def _at_step(name: str, step: dict[str, Any]) -> NDArray[np.float32]:
    return own_rewards(name, step["env"])


TERMS: dict[str, RewardTerm] = {name: partial(_at_step, name) for name in ("footing", "clearance", "tracking")}
"""Reward terms by name: feet that stay where they stand, room to obstacles, and the clip's poses at its tempo."""


def check_terms(objectives: Iterable[str], env: VecEnv) -> None:
    """Refuse objectives of `TERMS` that these environments cannot reward.

    Raises:
        ValueError: naming the first of them.
    """
    for name in objectives:
        if name in TERMS:
            own_rewards(name, env)
