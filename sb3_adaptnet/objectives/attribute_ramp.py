"""Environment attributes that change while training goes on: pushes that grow, and the like."""

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from sb3_adaptnet.vec_env import AdaptVecEnv


class AttributeRamp(BaseCallback):
    """Moves an attribute of the environment linearly from `first` to `last` over a number of samples.

    The value depends on the model's samples alone, so a resumed run goes on where it was. With a `spread` the worlds
    share out easy and hard, so that the easy goes on being met while the hard grows.
    """

    def __init__(self, attribute: str, first: float, last: float, samples: int, spread: float = 0.0) -> None:
        """Choose the ramp.

        Args:
            attribute: name of a number that the environment lets one set, such as "push_scale".
            first: value at the start.
            last: value from `samples` samples on.
            samples: length of the ramp, in control steps over all worlds.
            spread: the worlds' values lie evenly between the ramp's and this share less of it; 0 for the same in all,
                1 for everything from none on. Other than 0 it needs an attribute that is one for each world.

        Raises:
            ValueError: if `samples` is not positive, or `spread` lies outside [0, 1].
        """
        super().__init__()
        if not 0 <= spread <= 1:
            raise ValueError(f"the spread of a ramp lies within 0 to 1, which {spread} does not")
        if samples <= 0:
            raise ValueError(f"a ramp takes a positive number of samples, not {samples}")
        self.attribute, self.first, self.last, self.samples = attribute, first, last, samples
        self.spread = spread

    def value(self, done: int) -> float:
        """Value after `done` samples."""
        return self.first + (self.last - self.first) * min(done / self.samples, 1.0)

    def _init_callback(self) -> None:
        try:
            self.training_env.get_attr(self.attribute)
        except AttributeError as error:
            raise ValueError(f"the environment has no attribute {self.attribute!r} that a ramp could move") from error

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:
        value = self.value(self.model.num_timesteps)
        worlds = self.training_env.num_envs
        values = value * np.linspace(1, 1 - self.spread, worlds) if self.spread else value
        set_in_worlds(self.training_env, self.attribute, values)
        self.logger.record(f"rollout/{self.attribute}", value)


def set_in_worlds(env: VecEnv, attribute: str, values: float | NDArray[np.floating]) -> None:
    """Set an attribute of the worlds themselves, where `set_attr` would stop at the outermost `gym.Wrapper`.

    Args:
        env: the worlds.
        attribute: its name.
        values: one for all of the N worlds, or (N,).
    """
    if isinstance(env.unwrapped, AdaptVecEnv):
        env.set_attr(attribute, values)
        return
    for world, value in enumerate(np.broadcast_to(values, env.num_envs)):
        env.env_method("set_wrapper_attr", attribute, float(value), indices=[world])
