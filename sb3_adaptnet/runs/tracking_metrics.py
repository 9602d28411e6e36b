"""Numbers of SVG's rollouts, under the names that PPO's have."""

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback

from sb3_adaptnet.objectives.rollout_log import Rollout
from sb3_adaptnet.objectives.weighting import GOAL
from sb3_adaptnet.runs.history import reward_column

TRACKING_METRICS = ("falls_per_minute", "episode_length", "tracking_error")
"""Columns of `progress.csv` besides the goal's reward."""


class TrackingMetrics(BaseCallback):
    """Means over the last rollout.

    Attributes:
        objectives: "goal" alone.
        metrics: the goal's mean reward, falls per minute, control steps of the episodes that ended, and the mean
            distance of the links from the reference motion [m].
    """

    objectives: tuple[str, ...] = (GOAL,)

    def __init__(self) -> None:
        """Prepare."""
        super().__init__()
        self.metrics: dict[str, float] = {}

    def _on_rollout_start(self) -> None:
        model = self.model
        self._rollout = Rollout(model.n_steps, model.n_envs)  # type: ignore[attr-defined]  # SVG has steps
        self._errors: list[float] = []

    def _on_step(self) -> bool:
        step = self.locals
        self._rollout.add({GOAL: step["rewards"]}, step["dones"], step["infos"], None)
        self._errors.append(float(np.nanmean(step["step"].errors)))
        return True

    def _on_rollout_end(self) -> None:
        lengths = self.locals["worlds"].lengths
        self.metrics = {
            reward_column(GOAL): float(self._rollout.rewards[GOAL].mean()),
            "falls_per_minute": self._rollout.falls_per_minute(),
            "tracking_error": float(np.mean(self._errors)),
        }
        if lengths:
            self.metrics["episode_length"] = float(np.mean(lengths))
