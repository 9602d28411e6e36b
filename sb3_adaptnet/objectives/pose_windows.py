"""Pose windows of any Stable-Baselines3 VecEnv: native, DummyVecEnv, SubprocVecEnv, wrapped or not."""

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

NEEDED = "the discriminators need an environment with `pose_windows` and `sample_reference_windows(n, rng)`"
"""What an error says of an environment that lacks either."""


def pose_windows(env: VecEnv) -> NDArray[np.float32]:
    """Return the windows (N, 5, 15, 7) of the transition just made: position [m] and quaternion wxyz per link.

    Raises:
        ValueError: if the environment has no `pose_windows`.
    """
    windows = getattr(env, "pose_windows", None)
    if windows is not None:
        return np.asarray(windows, np.float32)
    try:
        return np.asarray(env.get_attr("pose_windows"), np.float32)
    except AttributeError as error:
        raise ValueError(f"{NEEDED}; {type(env).__name__} has no pose_windows") from error


def reference_windows(env: VecEnv, count: int, rng: np.random.Generator) -> NDArray[np.float32]:
    """Sample `count` windows (count, 5, 15, 7) from the environment's clips.

    A child generator goes to the environment, since one in another process could not advance `rng`.

    Raises:
        ValueError: if the environment has no `sample_reference_windows`.
    """
    child = np.random.default_rng(rng.integers(2**63))
    sample = getattr(env, "sample_reference_windows", None)
    if sample is not None:
        return np.asarray(sample(count, child), np.float32)
    try:
        (windows,) = env.env_method("sample_reference_windows", count, child, indices=[0])
    except AttributeError as error:
        raise ValueError(f"{NEEDED}; {type(env).__name__} has no sample_reference_windows") from error
    return np.asarray(windows, np.float32)
