"""A real rollout: what happened in the worlds, what they were after, and what they should have looked like."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.guide import Guidance
from sb3_adaptnet.world_model.transitions import Transitions

_ON_TO_THE_NEXT = 0.5
"""Share of the windows across an episode's end that begin with the next episode instead."""


@dataclass(frozen=True, eq=False)
class Moment:
    """N worlds before a step.

    Attributes:
        qpos, qvel: (N, 7 + J) and (N, 6 + J), MuJoCo's.
        frames: (N, 4, L, 13) link states up to now, world frame.
        targets: (N, 2) of the goals [m], world.
        speeds: (N,) of the goals [m/s].
    """

    qpos: NDArray[np.float32]
    qvel: NDArray[np.float32]
    frames: NDArray[np.float32]
    targets: NDArray[np.float32]
    speeds: NDArray[np.float32]


class Guided(NamedTuple):
    """What B worlds should look like, and where they should go, after a step.

    Attributes:
        phases: (B,) of the reference motion.
        headings: (B,) of the guides [rad], world.
        turn_rates: (B,) [rad/s].
        style: (B,) what the style's loss is worth.
        targets: (B, 2) of the goals [m], world.
        speeds: (B,) preferred [m/s].
        strengths: (B,) at which the adaptation acted.
        mirrored: (B,) whether this is the mirror image of what happened.
        means: (B, J) mean actions that led there, or their mirror images.
        weights: (B,) 1 where the episode went on, else 0.
        last: (B,) whether the world is seen for the last time in its episode or window.
    """

    phases: torch.Tensor
    headings: torch.Tensor
    turn_rates: torch.Tensor
    style: torch.Tensor
    targets: torch.Tensor
    speeds: torch.Tensor
    strengths: torch.Tensor
    mirrored: torch.Tensor
    means: torch.Tensor
    weights: torch.Tensor
    last: torch.Tensor

    def of(self, worlds: torch.Tensor) -> "Guided":
        """The same of some worlds (b,)."""
        return Guided(*(part[worlds] for part in self))


@dataclass(frozen=True, eq=False)
class RealRollout:
    """T steps of N worlds.

    Attributes:
        transitions: states, actions and ends.
        noise: (T, N, J) what was added to the policy's mean actions.
        frames: (T, N, 4, L, 13) link states up to each step, world frame.
        targets, speeds: (T + 1, N, 2) [m] and (T + 1, N) [m/s] of the goals before each step, and after the last one.
        phases: (T, N) of the reference motion after each step.
        headings: (T, N) of the guides after each step [rad], world.
        turn_rates: (T, N) of the guides [rad/s].
        style: (T, N) what the style's loss is worth after each step; less at part of the strength, by its square.
        failed: (T, N) whether the step ended an episode by the character's fault: a fall, the error, lost, diverged.
        strengths: (N,) at which the adaptation acted, 1 for the whole.
        mirrored: (N,) whether all this is the mirror image of what happened.
        companions: (N,) number of the frozen adaptation that acted beside, 0 for none.
    """

    transitions: Transitions
    noise: NDArray[np.float32]
    frames: NDArray[np.float32]
    targets: NDArray[np.float32]
    speeds: NDArray[np.float32]
    phases: NDArray[np.integer]
    headings: NDArray[np.float32]
    turn_rates: NDArray[np.float32]
    style: NDArray[np.float32]
    failed: NDArray[np.bool_]
    strengths: NDArray[np.float32]
    mirrored: NDArray[np.bool_]
    companions: NDArray[np.integer]

    def __len__(self) -> int:
        """T."""
        return len(self.transitions)

    def of(self, worlds: NDArray[np.integer]) -> "RealRollout":
        """The same of some worlds (n,)."""
        by_time = ("noise", "frames", "targets", "speeds", "phases", "headings", "turn_rates", "style", "failed")
        return RealRollout(
            transitions=self.transitions.of(worlds),
            **{name: getattr(self, name)[:, worlds] for name in by_time},
            strengths=self.strengths[worlds],
            mirrored=self.mirrored[worlds],
            companions=self.companions[worlds],
        )

    def window(self, starts: NDArray[np.integer] | int, steps: int) -> "RealRollout":
        """`steps` steps of each world from its own start, (N,), on."""
        data, worlds = self.transitions, np.arange(self.transitions.num_worlds)
        states = np.broadcast_to(starts, worlds.shape) + np.arange(steps + 1)[:, None]
        times = states[:-1]
        by_step = ("noise", "frames", "phases", "headings", "turn_rates", "style", "failed")
        return RealRollout(
            transitions=Transitions(
                data.qpos[states, worlds], data.qvel[states, worlds], data.actions[times, worlds],
                data.ended[times, worlds],
            ),
            **{name: getattr(self, name)[times, worlds] for name in by_step},
            targets=self.targets[states, worlds],
            speeds=self.speeds[states, worlds],
            strengths=self.strengths,
            mirrored=self.mirrored,
            companions=self.companions,
        )  # fmt: skip

    def drawn_starts(self, steps: int, rng: np.random.Generator) -> NDArray[np.integer]:
        """(N,) first steps of windows of so many: evenly drawn, but half of those across an end begin after it.

        What follows an end in a window counts nothing, and few windows begin just where an episode does.
        """
        worlds, last, ended = np.arange(self.transitions.num_worlds), len(self) - steps, self.transitions.ended
        starts = rng.integers(last + 1, size=len(worlds))
        crossed = ended[starts + np.arange(steps)[:, None], worlds]
        after = starts + 1 + crossed.argmax(0)
        begins = (after <= last) & ~ended[np.minimum(after, last), worlds]
        on = crossed.any(0) & begins & (rng.random(len(worlds)) < _ON_TO_THE_NEXT)
        return np.where(on, after, starts)

    @property
    def alive(self) -> NDArray[np.bool_]:
        """(T, N) whether the episode that a world is in at first goes on through each step."""
        return ~np.logical_or.accumulate(self.transitions.ended, axis=0)

    def guided(self, step: int, alive: NDArray[np.bool_], last: NDArray[np.bool_], device: torch.device) -> Guided:
        """What the worlds should look like after a step; `alive` and `last` (N,) become `weights` and `last`."""
        parts = [part[step] for part in (self.phases, self.headings, self.turn_rates, self.style)]
        goals = [self.targets[step + 1], self.speeds[step + 1]]
        acted = [self.strengths, self.mirrored, self.transitions.actions[step] - self.noise[step]]
        rest = [alive.astype(np.float32), last]
        return Guided(*(moving(part, device) for part in (*parts, *goals, *acted, *rest)))


class RolloutRecorder:
    """Gathers a rollout step by step."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self._moments: list[Moment] = []
        self._actions: list[NDArray[np.float32]] = []
        self._noise: list[NDArray[np.float32]] = []
        self._guidance: list[Guidance] = []
        self._ended: list[NDArray[np.bool_]] = []
        self._failed: list[NDArray[np.bool_]] = []

    def add(
        self,
        before: Moment,
        actions: NDArray[np.float32],
        noise: NDArray[np.float32],
        guidance: Guidance,
        ended: NDArray[np.bool_],
        failed: NDArray[np.bool_],
    ) -> None:
        """Add a step: the worlds before it, actions and noise (N, J), the guidance after it, which episodes ended."""
        self._moments.append(before)
        self._actions.append(actions)
        self._noise.append(noise)
        self._guidance.append(guidance)
        self._ended.append(ended)
        self._failed.append(failed)

    def finish(self, last: Moment, strengths: NDArray[np.float32], companions: NDArray[np.integer]) -> RealRollout:
        """The rollout, given the worlds after its last step, and who (N,) acted beside the adaptation how strongly."""
        moments, guidance = [*self._moments, last], self._guidance
        transitions = Transitions(
            qpos=np.stack([moment.qpos for moment in moments]),
            qvel=np.stack([moment.qvel for moment in moments]),
            actions=np.stack(self._actions),
            ended=np.stack(self._ended),
        )
        return RealRollout(
            transitions=transitions,
            noise=np.stack(self._noise),
            frames=np.stack([moment.frames for moment in moments[:-1]]),
            targets=np.stack([moment.targets for moment in moments]),
            speeds=np.stack([moment.speeds for moment in moments]),
            phases=np.stack([now.phases for now in guidance]),
            headings=np.stack([now.headings for now in guidance]),
            turn_rates=np.stack([now.turn_rates for now in guidance]),
            style=strengths**2 * np.stack([now.style for now in guidance]),
            failed=np.stack(self._failed),
            strengths=strengths,
            mirrored=np.zeros(len(strengths), np.bool_),
            companions=companions,
        )


def moving(values: NDArray[np.generic], device: torch.device) -> torch.Tensor:
    """An array as a tensor on a device."""
    return torch.as_tensor(values).to(device)


def root_headings(qpos: NDArray[np.floating]) -> NDArray[np.floating]:
    """Headings (...) [rad], world, of the roots in MuJoCo's positions (..., 7 + J)."""
    w, x, y, z = np.moveaxis(qpos[..., 3:7], -1, 0)
    return np.asarray(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
