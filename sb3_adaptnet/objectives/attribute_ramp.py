"""Environment attributes that change while training goes on: pushes that grow, and the like."""

from collections.abc import Mapping
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from sb3_adaptnet.objectives.rollout_log import CONTROL_HZ, is_fall
from sb3_adaptnet.stacking import JoinedWorlds
from sb3_adaptnet.vec_env import AdaptVecEnv


class AttributeRamp(BaseCallback):
    """Moves an attribute of the environment linearly from `first` to `last` over a number of samples.

    With a `spread` the worlds share out easy and hard, so that the easy goes on being met while the hard grows. With
    `falls_per_minute` it is the learning that sets the pace: a rollout without falls moves the ramp by its samples, one
    with so many falls by none, and one with more moves it back.

    Attributes:
        position: samples that the ramp has moved by.
    """

    def __init__(
        self,
        attribute: str,
        first: float,
        last: float,
        samples: int,
        spread: float = 0.0,
        falls_per_minute: float | None = None,
    ) -> None:
        """Choose the ramp.

        Args:
            attribute: name of a number that the environment lets one set, such as "push_scale".
            first: value at the start.
            last: value at the end.
            samples: length of the ramp, in control steps over all worlds.
            spread: the worlds' values lie evenly between the ramp's and this share less of it; 0 for the same in all,
                1 for everything from none on. Other than 0 it needs an attribute that is one for each world.
            falls_per_minute: falls per simulated minute, mean over the worlds, at which the ramp stands still; None
                moves it with the samples whatever happens.

        Raises:
            ValueError: for what is no number, if `samples` or `falls_per_minute` is not positive, or `spread` lies
                outside [0, 1].
        """
        super().__init__()
        for name, number in {"first": first, "last": last, "samples": samples, "spread": spread}.items():
            if not isinstance(number, Real):
                raise ValueError(f"{name} of a ramp must be a number, not {number!r}")
        if not 0 <= spread <= 1:
            raise ValueError(f"the spread of a ramp lies within 0 to 1, which {spread} does not")
        if samples <= 0:
            raise ValueError(f"a ramp takes a positive number of samples, not {samples}")
        if falls_per_minute is not None and falls_per_minute <= 0:
            raise ValueError(f"a ramp stands still at a positive number of falls a minute, not {falls_per_minute}")
        self.attribute, self.first, self.last, self.samples = attribute, first, last, samples
        self.spread, self.falls_per_minute = spread, falls_per_minute
        self.position, self._falls, self._seen = 0.0, 0, 0

    @property
    def value(self) -> float:
        """The ramp's value in this rollout."""
        return self.first + (self.last - self.first) * min(self.position / self.samples, 1.0)

    def _init_callback(self) -> None:
        try:
            self.training_env.get_attr(self.attribute)
        except AttributeError as error:
            raise ValueError(f"the environment has no attribute {self.attribute!r} that a ramp could move") from error

    def _on_step(self) -> bool:
        infos = self.locals["infos"]
        self._falls += sum(is_fall(infos[world]) for world in np.flatnonzero(self.locals["dones"]))
        self._seen += len(infos)
        return True

    def _on_rollout_start(self) -> None:
        self._move()
        worlds = self.training_env.num_envs
        values = self.value * (1 - self.spread * _shares(worlds)) if self.spread else self.value
        set_in_worlds(self.training_env, self.attribute, values)
        self.logger.record(f"rollout/{self.attribute}", self.value)

    def _move(self) -> None:
        if self.falls_per_minute is None:
            self.position = float(self.model.num_timesteps)
        elif self._seen:
            falls = self._falls / (self._seen / CONTROL_HZ / 60.0)
            pace = max(1.0 - falls / self.falls_per_minute, -1.0)
            self.position = min(max(self.position + pace * self._seen, 0.0), float(self.samples))
        self._falls = self._seen = 0

    def state_dict(self) -> dict[str, Any]:
        """Where the ramp stands between two rollouts, for resuming a run."""
        return {"position": self.position, "falls": self._falls, "seen": self._seen}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Restore what `state_dict` gave."""
        self.position, self._falls, self._seen = float(state["position"]), int(state["falls"]), int(state["seen"])


def set_in_worlds(env: VecEnv, attribute: str, values: float | NDArray[np.floating]) -> None:
    """Set an attribute of the worlds themselves, where `set_attr` would stop at the outermost `gym.Wrapper`.

    Args:
        env: the worlds.
        attribute: its name.
        values: one for all of the N worlds, or (N,).
    """
    if isinstance(env.unwrapped, AdaptVecEnv | JoinedWorlds):
        env.set_attr(attribute, values)
        return
    for world, value in enumerate(np.broadcast_to(values, env.num_envs)):
        env.env_method("set_wrapper_attr", attribute, float(value), indices=[world])


def _shares(worlds: int) -> NDArray[np.float64]:
    """Numbers (N,) evenly from 0 to 1, so mixed that neighbours, such as joined groups of worlds, have of all of them.

    The ranks of multiples of the golden ratio, whose fractional parts never crowd.
    """
    places = np.arange(worlds) * (np.sqrt(5) - 1) / 2 % 1
    return places.argsort().argsort() / max(worlds - 1, 1)
