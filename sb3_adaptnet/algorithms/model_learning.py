"""Fitting a world model that is new, and keeping any up to date with what the policy does."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.rollouts.recent_rollouts import RecentRollouts
from sb3_adaptnet.algorithms.svg_settings import ModelRefresh
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.weights.weight_file import CheckpointError
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.fitting.collecting import Act, collect
from sb3_adaptnet.world_model.fitting.fit import (
    STAGES,
    descend,
    fit,
    loss_of,
    sample_starts,
    scaled,
    set_statistics,
)
from sb3_adaptnet.world_model.model import WorldModel
from sb3_adaptnet.world_model.transitions import Transitions
from sb3_adaptnet.world_model.world_file import beside_base, read_world

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


def refresh(
    model: WorldModel,
    optimizer: torch.optim.Optimizer,
    rollouts: RecentRollouts,
    settings: ModelRefresh,
    rng: np.random.Generator,
) -> float:
    """Fit the model to single steps of the latest rollouts; returns the mean loss."""
    losses, latest = [], rollouts.latest(settings.rollouts)
    for _ in range(settings.updates):
        data = latest[int(rng.integers(len(latest)))].transitions
        loss = loss_of(model, data, sample_starts(data, 1, settings.batch, rng), 1)
        descend(model, optimizer, loss)
        losses.append(float(loss.detach()))
    return float(np.mean(losses))


def opened(given: str | Path | WorldModel | None, base: str | Path) -> WorldModel:
    """A model of one's own from a model, a file, or None for the one beside the base.

    Raises:
        CheckpointError: if there is none, or the file cannot be read.
    """
    if given is None:
        given = beside_base(base)
        if not given.is_file():
            fit = f"fit one by `adaptnet world-model fit {base}`, and name its file"
            raise CheckpointError(f"{str(base)!r} has no {given.name} beside it: {fit}")
    return copy.deepcopy(given) if isinstance(given, WorldModel) else read_world(given).model


def fitted_to(model: WorldModel, character: Character) -> WorldModel:
    """The model for a character with other measures: the kinematics are exact at once, the dynamics have to learn.

    Raises:
        ValueError: if the characters differ in more than measures.
    """
    if model.character == character:
        return model
    for what in ("links", "parents", "joints", "hinges"):
        has, wanted = getattr(model.character, what), getattr(character, what)
        if has != wanted:
            differ = sorted(map(str, set(has) ^ set(wanted))) or "their order"
            raise ValueError(f"the world model is of a character with other {what}; they differ in {differ}")
    other = WorldModel(character, model.sizes)
    other.load_state_dict(model.state_dict())
    return other
