"""The native vector environment under the constructor that rl_zoo3 calls."""

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker, TimeLimit
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv

from sb3_adaptnet.runs.worlds import training_ground
from sb3_adaptnet.vec_env import AdaptVecEnv

KNOWN_WRAPPERS = (PassiveEnvChecker, OrderEnforcing, TimeLimit, Monitor)
"""What `gym.make` and rl_zoo3 put around every environment; the batch does the same by itself."""


class ZooVecEnv(AdaptVecEnv):
    """`AdaptVecEnv` made from a list of functions, like `DummyVecEnv`: N functions stand for N worlds.

    Only the first is called, for its spec. More than one world means training: the first episodes' lengths are spread.
    An environment that opens a window cannot be batched; it becomes a `DummyVecEnv`.
    """

    def __new__(cls, env_fns: Sequence[Callable[[], gym.Env]], **env_kwargs: Any) -> VecEnv:  # type: ignore[misc]  # not always this class
        """Choose between the native worlds and `DummyVecEnv`."""
        single = env_fns[0]()
        single.close()
        if single.render_mode == "human":
            return DummyVecEnv(list(env_fns))
        return super().__new__(cls)

    def __init__(self, env_fns: Sequence[Callable[[], gym.Env]], **env_kwargs: Any) -> None:
        """Make `len(env_fns)` worlds.

        Raises:
            ValueError: if the environment was not made from a registered id, or is wrapped in more than `gym.make` and
                rl_zoo3 put around every environment.
        """
        single = env_fns[0]()
        spec = single.spec
        single.close()
        if spec is None:
            raise ValueError("ZooVecEnv needs a registered environment; this one has no spec")
        while isinstance(single, gym.Wrapper):
            if type(single) not in KNOWN_WRAPPERS:
                raise ValueError(f"worlds in a batch have no wrappers of their own, as {type(single).__name__} is one")
            single = single.env
        training = len(env_fns) > 1
        if training:  # rl_zoo3 seeds numpy's global generator before it makes environments
            env_kwargs = {**training_ground(spec, int(np.random.randint(2**31 - 1))), **env_kwargs}
        super().__init__(spec, num_envs=len(env_fns), stagger=training, **env_kwargs)
