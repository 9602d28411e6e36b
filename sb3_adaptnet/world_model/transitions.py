"""Recorded transitions of many worlds, from which models are fitted and along which slopes are taken."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.world_model.state import State


@dataclass(frozen=True, eq=False)
class Transitions:
    """T control steps of N worlds.

    Attributes:
        qpos: (T + 1, N, 7 + J) MuJoCo's positions before each step, and after the last one.
        qvel: (T + 1, N, 6 + J) its velocities.
        actions: (T, N, J) in [-1, 1].
        ended: (T, N) whether the step ended an episode: the state after it belongs to another one.
    """

    qpos: NDArray[np.float32]
    qvel: NDArray[np.float32]
    actions: NDArray[np.float32]
    ended: NDArray[np.bool_]
    _starts: dict[int, NDArray[np.int64]] = field(default_factory=dict, init=False, repr=False)

    def __len__(self) -> int:
        """T."""
        return len(self.actions)

    @property
    def num_worlds(self) -> int:
        """N."""
        return self.actions.shape[1]

    def starts(self, steps: int) -> NDArray[np.int64]:
        """(n, 2) time and world from which on `steps` transitions belong to one episode."""
        if steps not in self._starts:
            ends = np.cumsum(self.ended, axis=0, dtype=np.int64)
            before = np.concatenate([np.zeros((1, self.num_worlds), np.int64), ends])
            self._starts[steps] = np.argwhere(before[steps:] == before[: len(before) - steps])
        return self._starts[steps]

    def states(self, starts: NDArray[np.integer], later: int = 0) -> State:
        """The states `later` steps after (n, 2) starts, on the CPU."""
        times, worlds = starts[:, 0] + later, starts[:, 1]
        return State.from_mujoco(torch.as_tensor(self.qpos[times, worlds]), torch.as_tensor(self.qvel[times, worlds]))

    def actions_at(self, starts: NDArray[np.integer], later: int = 0) -> torch.Tensor:
        """The actions (n, J) chosen `later` steps after (n, 2) starts."""
        return torch.as_tensor(self.actions[starts[:, 0] + later, starts[:, 1]])

    def split(self, held_out: int) -> tuple["Transitions", "Transitions"]:
        """What to fit, and every `held_out`-th world to judge by.

        Raises:
            ValueError: if there are fewer worlds than that.
        """
        if not 1 < held_out <= self.num_worlds:
            raise ValueError(f"every {held_out}th of {self.num_worlds} worlds cannot be held out")
        apart = np.arange(self.num_worlds) % held_out == 0
        return self.of(~apart), self.of(apart)

    @staticmethod
    def together(parts: Sequence["Transitions"]) -> "Transitions":
        """Records of equally many steps as one, of all their worlds."""
        names = ("qpos", "qvel", "actions", "ended")
        return Transitions(*(np.concatenate([getattr(part, name) for part in parts], axis=1) for name in names))

    def of(self, worlds: NDArray[np.bool_] | NDArray[np.integer]) -> "Transitions":
        """The same of some worlds, which a mask (N,) or their numbers (n,) name."""
        return Transitions(self.qpos[:, worlds], self.qvel[:, worlds], self.actions[:, worlds], self.ended[:, worlds])
