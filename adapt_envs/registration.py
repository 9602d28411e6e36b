"""From the table of environments to Gymnasium's registry."""

from importlib import import_module
from typing import Any

import gymnasium as gym
from gymnasium.envs.registration import EnvSpec

from adapt_envs.suite import EPISODE_STEPS, SUITE, TaskSpec
from adapt_envs.vector_env import AdaptVectorEnv


def env_id(name: str) -> str:
    """Gymnasium id of the environment called `name`."""
    return f"AdaptNet/Humanoid-{name}-v0"


def register_suite() -> None:
    """Register every row of `SUITE` that is not registered yet."""
    for name in SUITE:
        if env_id(name) not in gym.registry:
            _register(name, name)


def register(spec: TaskSpec, name: str) -> str:
    """Add your own environment to the table and to Gymnasium's registry.

    Args:
        spec: its row.
        name: its name: letters and digits, not taken by another row.

    Returns:
        Its Gymnasium id, `AdaptNet/Humanoid-NAME-v0`.

    Raises:
        ValueError: if the name is taken or unusable.
    """
    if not (name.isascii() and name.isalnum()):
        raise ValueError(f"{name!r} cannot be an environment's name, expected ASCII letters and digits")
    if name in SUITE and SUITE[name] != spec:
        raise ValueError(f"an environment is named {name!r} already; the names are {', '.join(SUITE)}")
    SUITE[name] = spec
    # The row itself travels in Gymnasium's record: a process that never saw this call can make the environment.
    _register(name, spec)
    return env_id(name)


def _register(name: str, task: str | TaskSpec) -> None:
    gym.register(
        env_id(name),
        entry_point="adapt_envs.env:AdaptEnv",
        vector_entry_point="adapt_envs.vector_env:AdaptVectorEnv",
        max_episode_steps=EPISODE_STEPS,
        kwargs={"task": task},
    )


def make_vector(environment: str, num_envs: int, **kwargs: Any) -> AdaptVectorEnv:
    """`num_envs` worlds of the id `environment` on the native batch; keyword arguments as `AdaptVectorEnv`'s.

    Raises:
        ValueError: for an id of another suite, or of a module that is not there.
        gymnasium.error.Error: if no such id is registered.
    """
    if "task" not in spec_of(environment).kwargs:
        ids = ", ".join(env_id(name) for name in SUITE)
        raise ValueError(f"{environment!r} is not of this suite; its ids are {ids}")
    env = gym.make_vec(environment, num_envs=num_envs, vectorization_mode="vector_entry_point", **kwargs)
    assert isinstance(env, AdaptVectorEnv)
    return env


def spec_of(environment: str) -> EnvSpec:
    """Spec of an id; the module that it may name ("module:id") is imported first, as `gym.make` does.

    Raises:
        ValueError: if there is no such module.
        gymnasium.error.Error: if no such id is registered.
    """
    module, _, name = environment.rpartition(":")
    if module:
        try:
            import_module(module)
        except ModuleNotFoundError as error:
            raise ValueError(f"{environment}: {error}; is its folder on PYTHONPATH?") from error
    return gym.spec(name)
