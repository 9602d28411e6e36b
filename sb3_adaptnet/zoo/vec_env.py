"""The native vector environment under the constructor that rl_zoo3 calls."""

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv

from sb3_adaptnet.vec_env import AdaptVecEnv


class ZooVecEnv(AdaptVecEnv):
    """`AdaptVecEnv` made from a list of functions, like `DummyVecEnv`: N functions stand for N worlds.

    Only the first is called, for its spec. More than one world means training: the first episodes' lengths are spread.
    An environment that opens a window cannot be batched; it becomes a `DummyVecEnv`.
    """

    def __new__(cls, env_fns: Sequence[Callable[[], gym.Env]], **env_kwargs: Any) -> VecEnv:  # type: ignore[misc]
        """Choose between the native worlds and `DummyVecEnv`."""
        single = env_fns[0]()
        single.close()
        if single.render_mode == "human":
            return DummyVecEnv(list(env_fns))
        return super().__new__(cls)

    def __init__(self, env_fns: Sequence[Callable[[], gym.Env]], **env_kwargs: Any) -> None:
        """Make `len(env_fns)` worlds.

        Raises:
            ValueError: if the environment was not made from a registered id.
        """
        single = env_fns[0]()
        spec = single.spec
        single.close()
        if spec is None:
            raise ValueError("ZooVecEnv needs a registered environment; this one has no spec")
        training = len(env_fns) > 1
        if training:  # rl_zoo3 seeds numpy's global generator before it makes environments
            env_kwargs = {**training_ground(spec, int(np.random.randint(2**31 - 1))), **env_kwargs}
        super().__init__(spec, num_envs=len(env_fns), stagger=training, **env_kwargs)


def spec_of(env_id: str) -> EnvSpec:
    """Spec of an id; the module that it may name ("module:id") is imported first, as `gym.make` does.

    Raises:
        ValueError: if there is no such module.
        gymnasium.error.Error: if no such id is registered.
    """
    module, _, name = env_id.rpartition(":")
    if module:
        try:
            import_module(module)
        except ModuleNotFoundError as error:
            raise ValueError(f"{env_id}: {error}; is its folder on PYTHONPATH?") from error
    return gym.spec(name)


def training_ground(spec: EnvSpec, seed: int) -> dict[str, int]:
    """Environment arguments that give a training terrain and obstacles of its own; evaluation's come from seed 0.

    Args:
        spec: the environment's; a terrain seed among its arguments stays.
        seed: the training's, from 0.

    Returns:
        `terrain_seed`, or nothing if it is set already or the environment is not of this suite.
    """
    return {"terrain_seed": seed + 1} if "task" in spec.kwargs and "terrain_seed" not in spec.kwargs else {}
