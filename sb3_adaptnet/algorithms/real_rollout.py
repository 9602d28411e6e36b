"""A real rollout: what happened in the worlds, what they were after, and what they should have looked like."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.guide import Guidance
from sb3_adaptnet.world_model.transitions import Transitions


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


@dataclass(frozen=True, eq=False)
class RealRollout:
    """T steps of N worlds.

    Attributes:
        transitions: states, actions and ends.
        noise: (T, N, J) what was added to the policy's mean actions.
        frames: (T, N, 4, L, 13) link states up to each step, world frame.
        targets, speeds: (T, N, 2) [m] and (T, N) [m/s] of the goals before each step.
        phases: (T, N) of the reference motion after each step.
        headings: (T, N) of the guides after each step [rad], world.
        turn_rates: (T, N) of the guides [rad/s].
    """

    transitions: Transitions
    noise: NDArray[np.float32]
    frames: NDArray[np.float32]
    targets: NDArray[np.float32]
    speeds: NDArray[np.float32]
    phases: NDArray[np.integer]
    headings: NDArray[np.float32]
    turn_rates: NDArray[np.float32]

    def __len__(self) -> int:
        """T."""
        return len(self.transitions)

    def alive(self, start: int, steps: int) -> NDArray[np.bool_]:
        """(steps, N) whether the episode that a world is in at `start` goes on through each step from there on."""
        return ~np.logical_or.accumulate(self.transitions.ended[start : start + steps], axis=0)


class RolloutRecorder:
    """Gathers a rollout step by step."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self._moments: list[Moment] = []
        self._actions: list[NDArray[np.float32]] = []
        self._noise: list[NDArray[np.float32]] = []
        self._guidance: list[Guidance] = []
        self._ended: list[NDArray[np.bool_]] = []

    def add(
        self,
        before: Moment,
        actions: NDArray[np.float32],
        noise: NDArray[np.float32],
        guidance: Guidance,
        ended: NDArray[np.bool_],
    ) -> None:
        """Add a step: the worlds before it, actions and noise (N, J), the guidance after it, which episodes ended."""
        self._moments.append(before)
        self._actions.append(actions)
        self._noise.append(noise)
        self._guidance.append(guidance)
        self._ended.append(ended)

    def finish(self, last: Moment) -> RealRollout:
        """The rollout, given the worlds after its last step."""
        moments, guidance = self._moments, self._guidance
        transitions = Transitions(
            qpos=np.stack([moment.qpos for moment in (*moments, last)]),
            qvel=np.stack([moment.qvel for moment in (*moments, last)]),
            actions=np.stack(self._actions),
            ended=np.stack(self._ended),
        )
        return RealRollout(
            transitions=transitions,
            noise=np.stack(self._noise),
            frames=np.stack([moment.frames for moment in moments]),
            targets=np.stack([moment.targets for moment in moments]),
            speeds=np.stack([moment.speeds for moment in moments]),
            phases=np.stack([now.phases for now in guidance]),
            headings=np.stack([now.headings for now in guidance]),
            turn_rates=np.stack([now.turn_rates for now in guidance]),
        )


def moving(values: NDArray[np.generic], device: torch.device) -> torch.Tensor:
    """An array as a tensor on a device."""
    return torch.as_tensor(values).to(device)
