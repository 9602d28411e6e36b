"""Keeping the world model up to date with what the policy does."""

from collections.abc import Sequence

import numpy as np
import torch

from sb3_adaptnet.algorithms.real_rollout import RealRollout
from sb3_adaptnet.algorithms.svg_settings import ModelRefresh
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.fitting.fit import descend, loss_of, sample_starts
from sb3_adaptnet.world_model.model import WorldModel


def refresh(
    model: WorldModel,
    optimizer: torch.optim.Optimizer,
    rollouts: Sequence[RealRollout],
    settings: ModelRefresh,
    rng: np.random.Generator,
) -> float:
    """Fit the model to single steps of the latest rollouts; returns the mean loss."""
    losses = []
    for _ in range(settings.updates):
        data = rollouts[int(rng.integers(len(rollouts)))].transitions
        loss = loss_of(model, data, sample_starts(data, 1, settings.batch, rng), 1)
        descend(model, optimizer, loss)
        losses.append(float(loss.detach()))
    return float(np.mean(losses))


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
