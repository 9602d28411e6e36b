"""What SVG writes to the log besides its losses."""

import sys
import time
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.utils import safe_mean

from sb3_adaptnet.algorithms.joined_tracking import JoinedTrackedWorlds
from sb3_adaptnet.algorithms.tracked_worlds import TrackedWorlds


def record_rollout(logger: Logger, errors: NDArray[np.floating], worlds: TrackedWorlds | JoinedTrackedWorlds) -> None:
    """Means of the tracking error [m], (T, N) over steps and worlds, of the episodes' lengths and of the strengths."""
    logger.record("rollout/tracking_error", float(np.nanmean(errors)))
    logger.record("rollout/strength", float(worlds.strengths.mean()))
    if worlds.lengths:
        logger.record("rollout/episode_steps", float(np.mean(worlds.lengths)))


def record_means(logger: Logger, updates: Sequence[Mapping[str, float]]) -> None:
    """Means of what the updates of a round gave."""
    for name in updates[0]:
        logger.record(f"svg/{name}", float(np.mean([update[name] for update in updates])))


def record_times(algorithm: BaseAlgorithm, iteration: int) -> None:
    """Episodes' rewards and times, under the names that Stable-Baselines3's own algorithms use."""
    logger, episodes = algorithm.logger, algorithm.ep_info_buffer
    begun, samples = algorithm.start_time, algorithm.num_timesteps - algorithm._num_timesteps_at_start
    seconds = max((time.time_ns() - begun) / 1e9, sys.float_info.epsilon)
    logger.record("time/iterations", iteration, exclude="tensorboard")
    if episodes:
        logger.record("rollout/ep_rew_mean", safe_mean([episode["r"] for episode in episodes]))
        logger.record("rollout/ep_len_mean", safe_mean([episode["l"] for episode in episodes]))
    logger.record("time/fps", int(samples / seconds))
    logger.record("time/time_elapsed", int(seconds), exclude="tensorboard")
    logger.record("time/total_timesteps", algorithm.num_timesteps, exclude="tensorboard")
