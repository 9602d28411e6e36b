"""Backpropagation through time along real rollouts: the model is used for its slopes alone (Heess et al. 2015)."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
import torch

from sb3_adaptnet.algorithms.rollouts.real_rollout import Guided, RealRollout, moving
from sb3_adaptnet.algorithms.tracking.tracked_motion import OBSERVED_FRAMES
from sb3_adaptnet.world_model.links import HeadingView, from_observed, to_observed
from sb3_adaptnet.world_model.model import WorldModel
from sb3_adaptnet.world_model.state import State

MeanAction = Callable[[torch.Tensor], torch.Tensor]
"""Observations (B, 784) -> mean actions (B, J), differentiable."""
_NO_DIRECTION = 0.01
"""Closer than this [m] a target has no direction, as in the environments."""


class Imagined(NamedTuple):
    """A step through the model.

    Attributes:
        state: after it.
        view: the last frames after it, heading frame.
        actions: (B, J) mean actions that led there.
        guided: what it should look like.
    """

    state: State
    view: HeadingView
    actions: torch.Tensor
    guided: Guided

    def last_seen(self) -> "Imagined | None":
        """The worlds whose state is the last of their episode or window, by their latest frame; None if none is."""
        worlds = self.guided.last.nonzero()[:, 0]
        if not len(worlds):
            return None
        view = HeadingView(*(part.index_select(-1, worlds) for part in self.view))
        state = self.state.map(lambda part: part.index_select(-1, worlds))
        return Imagined(state, view, self.actions[worlds], self.guided.of(worlds))


def goal_features(view: HeadingView, position: torch.Tensor, target: torch.Tensor, speed: torch.Tensor) -> torch.Tensor:
    """The goal's part of the observation, as the environments compute it.

    Args:
        view: for the heading.
        position: (3, B) of the root [m], world.
        target: (B, 2) of the goal [m], world.
        speed: (B,) preferred [m/s].

    Returns:
        (B, 4): unit direction in the heading frame (zero below 1 cm), distance [m], speed [m/s].
    """
    x, y = target.t() - position[:2]
    distance = torch.sqrt((x * x + y * y).clamp_min(1e-12))
    scale = torch.where(distance < _NO_DIRECTION, 0.0, 1 / distance.clamp_min(_NO_DIRECTION))
    ahead, aside = view.cos * x + view.sin * y, view.cos * y - view.sin * x
    return torch.stack((ahead * scale, aside * scale, distance, speed), dim=1)


def imagine(
    mean_action: MeanAction,
    model: WorldModel,
    rollout: RealRollout,
    tame: Callable[[torch.Tensor], torch.Tensor] = lambda part: part,
) -> Iterator[Imagined]:
    """Act again through a real rollout, or a window of one, with the real noise and each real step's residual added.

    While the policy is the one that acted, the imagined states are the real ones.

    Args:
        mean_action: the policy.
        model: a frozen world model.
        rollout: the rollout.
        tame: attached to each part of the states, for their gradients.

    Yields:
        Each step.
    """
    device = model.middles.device
    alive = rollout.alive
    last = alive & ~np.concatenate([alive[1:], np.zeros_like(alive[:1])])
    residuals = _residuals(model, rollout) * moving(alive, device).unsqueeze(-1)
    data = rollout.transitions
    state = State.from_mujoco(moving(data.qpos[0], device), moving(data.qvel[0], device))
    frames = [from_observed(moving(frame, device)) for frame in rollout.frames[0].swapaxes(0, 1)]
    view = model.view(torch.cat(frames, dim=1))
    for step in range(len(rollout)):
        target, speed = moving(rollout.targets[step], device), moving(rollout.speeds[step], device)
        goal = goal_features(view, state.position, target, speed)
        mean = mean_action(torch.cat((to_observed(view.links), goal), dim=1))
        actions = (mean + moving(rollout.noise[step], device)).clamp(-1, 1)
        state = model.step(state, view, actions, residuals[step]).map(tame)
        frames = [*frames[1 - OBSERVED_FRAMES :], model.kinematics(state)]
        view = model.view(torch.cat(frames, dim=1))
        yield Imagined(state, view, mean, rollout.guided(step, alive[step], last[step], device))


def _residuals(model: WorldModel, rollout: RealRollout) -> torch.Tensor:
    """(T, N, O) what each real step changed beyond what the model expects; without meaning where one ended."""
    data, device = rollout.transitions, model.middles.device
    steps, worlds = data.ended.shape
    before, after = (
        State.from_mujoco(
            moving(qpos.reshape(steps * worlds, -1), device), moving(qvel.reshape(steps * worlds, -1), device)
        )
        for qpos, qvel in ((data.qpos[:-1], data.qvel[:-1]), (data.qpos[1:], data.qvel[1:]))
    )
    actions = moving(data.actions.reshape(steps * worlds, -1), device)
    return model.residual(before, after, actions).view(steps, worlds, -1)
