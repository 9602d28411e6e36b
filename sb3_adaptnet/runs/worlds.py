"""The worlds that a run trains in."""

from typing import Any

from gymnasium.envs.registration import EnvSpec

from adapt_envs.registration import spec_of
from sb3_adaptnet.runs.experiment import Experiment
from sb3_adaptnet.runs.run_folder import RunSettings
from sb3_adaptnet.stacking.joined_worlds import JoinedWorlds, worlds_with_companions
from sb3_adaptnet.vec_env import AdaptVecEnv


def make_worlds(settings: RunSettings, entry: Experiment, **overrides: Any) -> AdaptVecEnv | JoinedWorlds:
    """Make the run's vector environment; where the policy has companions, worlds for each of them joined into one."""
    kwargs: dict[str, Any] = {"env": settings.env_id, "num_envs": settings.n_envs or entry.n_envs, "stagger": True}
    kwargs.update(training_ground(spec_of(settings.env_id), settings.seed))
    kwargs |= {"num_threads": settings.threads} | entry.env_kwargs
    if settings.motion is not None:
        kwargs["motion"] = settings.motion
    kwargs.update(overrides)
    companions = entry.arguments["policy_kwargs"].get("companions")
    return worlds_with_companions(companions, **kwargs) if companions else AdaptVecEnv(**kwargs)


def training_ground(spec: EnvSpec, seed: int) -> dict[str, int]:
    """Environment arguments that give each training another terrain and other obstacles; evaluation's come from seed 0.

    Args:
        spec: the environment's; a terrain seed among its arguments stays.
        seed: the training's, from 0.

    Returns:
        `terrain_seed`, or nothing if it is set already or the environment is not of this suite.
    """
    return {"terrain_seed": seed + 1} if "task" in spec.kwargs and "terrain_seed" not in spec.kwargs else {}
