"""What the callback keeps of a rollout beside PPO's buffer: windows, rewards, how episodes ended."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.modules.observation import parts_of, whole_of

TIME = "time"
CONTROL_HZ = 30
"""Control steps per simulated second [Hz] (the paper, sec. 7)."""


class Rollout:
    """Records of T steps of N worlds, overwritten by the next rollout.

    Attributes:
        windows: (T, N, frames, links, 7) pose windows, None until the first step (or without imitation).
        rewards: name to (T, N) reward of every objective that is known at the step.
        terminated: (T, N) bool, episodes that ended by a fall, lost or diverged.
        time_limits: (step, world, terminal observation) of the episodes that a time limit ended.
        ends: how often each end occurred, by name.
        lengths: steps of the episodes that ended.
    """

    def __init__(self, steps: int, worlds: int) -> None:
        """Make room for `steps` x `worlds` transitions."""
        self.shape = (steps, worlds)
        self.windows: NDArray[np.float32] | None = None
        self.rewards: dict[str, NDArray[np.float32]] = {}
        self.terminated = np.zeros(self.shape, bool)
        self.clear()

    def clear(self) -> None:
        """Start a new rollout."""
        self.step = 0
        self.terminated[:] = False
        self.time_limits: list[tuple[int, int, Any]] = []
        self.ends: Counter[str] = Counter()
        self.lengths: list[float] = []

    def add(
        self,
        rewards: dict[str, NDArray[np.float32]],
        dones: NDArray[np.bool_],
        infos: list[dict[str, Any]],
        windows: NDArray[np.float32] | None,
    ) -> None:
        """Copy one step; PPO changes `rewards` in place afterwards, and environments may reuse `windows`."""
        for name, column in rewards.items():
            self.rewards.setdefault(name, np.zeros(self.shape, np.float32))[self.step] = column
        if windows is not None:
            if self.windows is None:
                self.windows = np.zeros((*self.shape, *windows.shape[1:]), np.float32)
            self.windows[self.step] = windows
        for world in np.flatnonzero(dones):
            self._add_end(int(world), infos[world])
        self.step += 1

    def _add_end(self, world: int, info: dict[str, Any]) -> None:
        truncated = bool(info.get("TimeLimit.truncated", False))
        self.ends[end_of(info)] += 1
        if "episode" in info:
            self.lengths.append(float(info["episode"]["l"]))
        if truncated:
            self.time_limits.append((self.step, world, info["terminal_observation"]))
        else:
            self.terminated[self.step, world] = True

    def observations_to_bootstrap(self, last: Any) -> Any:
        """Observations whose values are still wanted: those that time limits cut, then the `last` ones (N, ...)."""
        if not self.time_limits:
            return last
        ended = [parts_of(observation) for _, _, observation in self.time_limits]
        stacked = {key: np.stack([parts[key] for parts in ended]) for key in ended[0]}
        return whole_of({key: np.concatenate([stacked[key], rows]) for key, rows in parts_of(last).items()})

    def falls_per_minute(self) -> float:
        """Falls, lost and diverged episodes per simulated minute."""
        minutes = self.step * self.shape[1] / CONTROL_HZ / 60.0
        return float(sum(n for end, n in self.ends.items() if end != TIME) / minutes)


def end_of(info: Mapping[str, Any]) -> str:
    """What ended an episode, of its last step's info: "time", or a fall of some kind."""
    return str(info.get("end", TIME if info.get("TimeLimit.truncated", False) else "fall"))


def is_fall(info: Mapping[str, Any]) -> bool:
    """Whether an episode ended by a fall, lost or diverged."""
    return end_of(info) != TIME
