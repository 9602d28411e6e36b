"""From the table of environments to Gymnasium's registry."""

import gymnasium as gym

from adapt_envs.suite import EPISODE_STEPS, SUITE
from adapt_envs.vector_env import AdaptVectorEnv


def env_id(name: str) -> str:
    """Gymnasium id of the environment called `name`."""
    return f"AdaptNet/Humanoid-{name}-v0"


def register_suite() -> None:
    """Register every row of `SUITE` that is not registered yet."""
    for name in SUITE:
        if env_id(name) not in gym.registry:
            gym.register(
                env_id(name),
                entry_point="adapt_envs.env:AdaptEnv",
                vector_entry_point="adapt_envs.vector_env:AdaptVectorEnv",
                max_episode_steps=EPISODE_STEPS,
                kwargs={"task": name},
            )


def make_vector(environment: str, num_envs: int, **kwargs: object) -> AdaptVectorEnv:
    """`num_envs` worlds of the id `environment` on the native batch; keyword arguments as `AdaptVectorEnv`'s.

    Raises:
        ValueError: for an id of another suite.
    """
    env = gym.make_vec(environment, num_envs=num_envs, vectorization_mode="vector_entry_point", **kwargs)
    if not isinstance(env, AdaptVectorEnv):
        raise ValueError(f"{environment!r} is not of this suite; its ids are {', '.join(env_id(name) for name in SUITE)}")
    return env
