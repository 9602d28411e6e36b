"""Environment attributes that change while training goes on: pushes that grow, and the like."""

from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

from sb3_adaptnet.vec_env import AdaptVecEnv


class AttributeRamp(BaseCallback):
    """Moves an attribute of the environment linearly from `first` to `last` over a number of samples.

    The value depends on the model's samples alone, so a resumed run goes on where it was.
    """

    def __init__(self, attribute: str, first: float, last: float, samples: int) -> None:
        """Choose the ramp.

        Args:
            attribute: name of a number that the environment lets one set, such as "push_scale".
            first: value at the start.
            last: value from `samples` samples on.
            samples: length of the ramp, in control steps over all worlds.

        Raises:
            ValueError: if `samples` is not positive.
        """
        super().__init__()
        if samples <= 0:
            raise ValueError(f"a ramp takes a positive number of samples, not {samples}")
        self.attribute, self.first, self.last, self.samples = attribute, first, last, samples

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
        set_in_worlds(self.training_env, self.attribute, value)
        self.logger.record(f"rollout/{self.attribute}", value)


def set_in_worlds(env: VecEnv, attribute: str, value: float) -> None:
    """Set an attribute of the worlds themselves, where `set_attr` would stop at the outermost `gym.Wrapper`."""
    if isinstance(env.unwrapped, AdaptVecEnv):
        env.set_attr(attribute, value)
    else:
        env.env_method("set_wrapper_attr", attribute, value)
