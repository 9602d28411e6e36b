"""The critic: which costs a state leads to. At a window's end it sees what the window is too short for: falls."""

from collections.abc import Sequence
from typing import NamedTuple, cast
from weakref import WeakKeyDictionary

import numpy as np
import torch
from stable_baselines3.common.logger import Logger
from torch import nn
from torch.nn import functional

from sb3_adaptnet.algorithms.imagination import Imagined
from sb3_adaptnet.algorithms.rollouts.cost_returns import costs_to_go
from sb3_adaptnet.algorithms.rollouts.real_rollout import Guided, RealRollout, moving
from sb3_adaptnet.algorithms.svg_loss import CostToCome, LossWeights, state_costs
from sb3_adaptnet.algorithms.svg_settings import CostToGo
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.algorithms.tracking.travel_loss import VELOCITY_SCALE, travel_errors
from sb3_adaptnet.objectives.schedule import value_at
from sb3_adaptnet.objectives.weight_average import WeightAverage
from sb3_adaptnet.world_model.links import HeadingView
from sb3_adaptnet.world_model.model import WorldModel
from sb3_adaptnet.world_model.state import State

LEARNING_RATE, BATCH = 1e-3, 512
"""Adam's, and states per update."""
RECENT = 12
"""Latest rollouts that it learns from: in each, few worlds fall."""
WIDTH = 256
"""Numbers of each of the two hidden layers."""
SCALE = 20.0
"""Costs-to-go are about so large; the last layer's numbers then are about 1."""
ERROR_SCALE = 100.0
"""Errors are squared in this unit. A loss that grows straight would find medians, and miss falls: they are rare."""
HARMONICS = 3
"""Sines and cosines of so many multiples of the phase's angle tell the phase."""
TASK_NUMBERS = 10 + 2 * HARMONICS
"""Numbers that tell the critic what a state should be like."""
_FIRST_SHARE = 0.1
"""The last layer starts with so small a share of its usual weights."""
_NO_DIRECTION = 0.05
"""Closer than this [m] the direction to the target fades."""


class CostCritic(nn.Module):
    """Posture and task (B, n) -> cost-to-go (B,), never negative.

    Attributes:
        updates: () so often it learned; it knows nothing before the first.
        average: of its weights over the updates, which it holds except while it learns.
    """

    updates: torch.Tensor

    def __init__(self, model: WorldModel) -> None:
        """Prepare for the postures of a world model."""
        super().__init__()
        # The model reads a posture and the joints' actions, the critic a posture and the motion's angles of the joints.
        inputs = len(model.dynamics.input_mean) + TASK_NUMBERS
        last = nn.Linear(WIDTH, 1)
        self.layers = nn.Sequential(
            nn.Linear(inputs, WIDTH), nn.SiLU(), nn.Linear(WIDTH, WIDTH), nn.SiLU(), last
        )  # fmt: skip
        self.register_buffer("updates", torch.zeros((), dtype=torch.long))
        with torch.no_grad():
            last.weight.mul_(_FIRST_SHARE)
        self.average = WeightAverage(list(self.layers.parameters()))

    def forward(self, inputs: torch.Tensor) -> torch.Tensor:
        """Costs-to-go (B,)."""
        return SCALE * functional.softplus(self.layers(inputs)[:, 0])


def critic_inputs(
    model: WorldModel, motion: TrackedMotion, state: State, view: HeadingView, guided: Guided
) -> torch.Tensor:
    """What the critic reads, (B, n): posture; errors, phase and goal relative to the guide; strength; motion's angles.

    The angles [rad] tell which of several motions a world follows, and so which companion acts there.
    """
    errors = travel_errors(state.velocity, view, motion, guided.phases, guided.headings, guided.speeds)
    cos, sin = torch.cos(guided.headings), torch.sin(guided.headings)
    x, y = guided.targets.t() - state.position[:2]
    distance = torch.sqrt(x * x + y * y).clamp_min(_NO_DIRECTION)
    angle, usual = motion.turns[guided.phases], motion.speeds.mean()
    task = [
        3 * (errors.alike - 1),
        2 * errors.turned_left,
        errors.ahead / VELOCITY_SCALE,
        errors.aside / VELOCITY_SCALE,
        guided.speeds / usual - 1,
        (cos * x + sin * y) / distance,
        (cos * y - sin * x) / distance,
        torch.tanh(distance),
        guided.turn_rates,
        3 * (guided.strengths - 1),
        *(wave(number * angle) for number in range(1, HARMONICS + 1) for wave in (torch.sin, torch.cos)),
    ]
    return torch.cat((model.posture(view, state), torch.stack(task, dim=1), motion.angles.t()[guided.phases]), dim=1)


class _Judged(NamedTuple):
    """A rollout as the critic sees it: inputs (T * N, n), costs, ended and failed (T, N)."""

    inputs: torch.Tensor
    costs: torch.Tensor
    ended: torch.Tensor
    failed: torch.Tensor


class CriticTraining:
    """Teaches a critic the costs of real rollouts."""

    def __init__(
        self,
        critic: CostCritic,
        optimizer: torch.optim.Optimizer,
        model: WorldModel,
        motion: TrackedMotion,
        settings: CostToGo,
        rng: np.random.Generator,
        logger: Logger,
    ) -> None:
        """Teach `critic` what the losses cost over time."""
        self.critic, self.optimizer, self.model, self.motion = critic, optimizer, model, motion
        self.settings, self.rng, self.logger = settings, rng, logger
        self.end_cost = value_at(settings.end_cost, 0)
        self._seen: WeakKeyDictionary[RealRollout, _Judged] = WeakKeyDictionary()

    def learned(self, samples: int, losses: LossWeights, rollouts: Sequence[RealRollout]) -> CostToCome | None:
        """What the critic adds to the loss, after it learned; None, and nothing learned, without a weight now."""
        weight = value_at(self.settings.weight, samples)
        if weight == 0:
            return None
        self.end_cost = value_at(self.settings.end_cost, samples)
        for name, value in self.learn(losses, rollouts).items():
            self.logger.record(f"svg/{name}", value)
        return self.to_come(weight)

    def to_come(self, weight: float) -> CostToCome:
        """What the critic adds to the loss, `weight` times."""

        def weighted(last: Imagined) -> torch.Tensor:
            inputs = critic_inputs(self.model, self.motion, last.state, last.view, last.guided)
            return cast(torch.Tensor, weight * self.critic(inputs))

        return weighted

    def learn(self, losses: LossWeights, rollouts: Sequence[RealRollout]) -> dict[str, float]:
        """Learn from rollouts, longer the first time; every other batch is from the last one.

        What a rollout costs stays what it was by the losses when it was new.

        Returns:
            What to log: mean target and explained share of the variance.
        """
        fresh = bool(self.critic.updates == 0)
        recent = [self._judged(rollout, losses) for rollout in rollouts]
        self.critic.requires_grad_(True)
        with self.critic.average.learning():
            log = self._learn_from(recent, self.settings.updates[0 if fresh else 1])
        self.critic.requires_grad_(False)
        return log

    def _learn_from(self, recent: Sequence[_Judged], updates: int) -> dict[str, float]:
        explained, target = [], torch.zeros(1)
        aims: list[torch.Tensor] = []
        for number in range(updates):
            if number % self.settings.updates[1] == 0:  # the critic's own values are in them
                with self.critic.average.acting():
                    aims = [self._aims(judged) for judged in recent]
            chosen = len(recent) - 1 if number % 2 == 0 else int(self.rng.integers(len(recent)))
            known = (~aims[chosen].isnan()).nonzero()[:, 0]
            if not len(known):
                continue
            rows = known[torch.as_tensor(self.rng.integers(len(known), size=BATCH), device=known.device)]
            target = aims[chosen][rows]
            explained.append(self._descend(recent[chosen].inputs[rows], target))
            self.critic.average.update(self.settings.average_decay)
        return {"cost_to_go": float(target.mean()), "critic_explains": float(np.mean(explained or [0.0]))}

    def _descend(self, inputs: torch.Tensor, target: torch.Tensor) -> float:
        error = self.critic(inputs) - target
        loss = (error / ERROR_SCALE).square().mean()
        self.optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.critic.parameters(), 1.0)
        self.optimizer.step()
        self.critic.updates += 1
        return float(1 - error.detach().square().mean() / target.var().clamp_min(1e-6))

    @torch.no_grad()
    def _aims(self, judged: _Judged) -> torch.Tensor:
        """(T * N,) costs-to-go, NaN where not known."""
        settings, values = self.settings, self.critic(judged.inputs).view_as(judged.costs)
        return costs_to_go(
            judged.costs, values, judged.ended, judged.failed,
            discount=settings.discount, trace=settings.trace, end_cost=self.end_cost,
        ).flatten()  # fmt: skip

    @torch.no_grad()
    def _judged(self, rollout: RealRollout, losses: LossWeights) -> _Judged:
        if rollout not in self._seen:
            device, data = self.model.middles.device, rollout.transitions
            inputs, costs = [], []
            for step, ended in enumerate(data.ended):
                after = (moving(part[step + 1], device) for part in (data.qpos, data.qvel))
                state = State.from_mujoco(*after)
                view = self.model.view(self.model.kinematics(state))
                guided = rollout.guided(step, ~ended, ended, device)
                inputs.append(critic_inputs(self.model, self.motion, state, view, guided))
                parts = state_costs(state, view, self.motion, guided, losses)
                costs.append(torch.stack(list(parts.values())).sum(0))
            ends = (moving(part, device) for part in (data.ended, rollout.failed))
            self._seen[rollout] = _Judged(torch.cat(inputs), torch.stack(costs), *ends)
        return self._seen[rollout]
