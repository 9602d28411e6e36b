"""World models from nothing: fitted before there is a policy, and again once the policy does what the motion does."""

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.world_model.fitting.collecting import Act, collect
from sb3_adaptnet.world_model.fitting.fit import STAGES, fit, scaled, set_statistics
from sb3_adaptnet.world_model.model import WorldModel
from sb3_adaptnet.world_model.transitions import Transitions

KEPT_ROWS = 50_000
"""Observations that are kept of a record."""


def record(env: AdaptVecEnv, act: Act, steps: int, rng: np.random.Generator) -> tuple[Transitions, NDArray[np.float32]]:
    """Let a policy act, disturbed. The worlds are reset before, and belong to nobody afterwards.

    Args:
        env: the worlds.
        act: the policy.
        steps: control steps of every world.
        rng: source of the disturbances.

    Returns:
        What happened, and observations (n, 784) of it.
    """
    seen: list[NDArray[np.float32]] = []
    rows = max(1, KEPT_ROWS // steps)

    def watched(observations: Any) -> NDArray[np.floating]:
        seen.append(observations[:rows].copy())
        return act(observations)

    return collect(env.vector_env, watched, steps, rng), np.concatenate(seen)


def fit_anew(
    model: WorldModel,
    data: Transitions,
    effort: float,
    rng: np.random.Generator,
    progress: Callable[[range], Any] = iter,
) -> None:
    """Fit a model from its first weights to what was recorded, with `effort` times the updates of one that ships."""
    model.load_state_dict(WorldModel(model.character, model.sizes).state_dict())
    set_statistics(model, data, rng)
    optimizer = torch.optim.Adam(model.parameters())
    stages = scaled(STAGES, effort)
    updates = iter(progress(range(sum(stage.updates for stage in stages))))
    for stage in stages:
        for _ in fit(model, data, stage, optimizer, rng):
            next(updates)


def servo_aims(motion: TrackedMotion) -> Act:
    """In place of a policy: servos aim where they would follow the motion. Characters stumble and fall by it."""
    aims = motion.aims.cpu().numpy()

    def act(observations: Any) -> NDArray[np.float32]:
        return np.asarray(aims[motion.nearest(motion.seen_in(observations))])

    return act
