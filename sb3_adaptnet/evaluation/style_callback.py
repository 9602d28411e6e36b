"""Whether a style is coming, seen while it is learned: the style's figures of the mean action now and then."""

import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.vec_env import VecEnv

from adapt_envs import AdaptVectorEnv
from sb3_adaptnet.evaluation.gait import Gait, clip_gait
from sb3_adaptnet.evaluation.recording import record_straight, reference_speed
from sb3_adaptnet.evaluation.style import style_figures, tempo_error_of_base
from sb3_adaptnet.objectives.weight_average import WeightAverage, WeightAveraging
from sb3_adaptnet.vec_env import AdaptVecEnv

WORLDS = 8
"""Worlds that are measured."""


class StyleCallback(BaseCallback):
    """Measures `StyleFigures` between two rollouts, in worlds of its own that are like the training's.

    They appear in the logger as `style/...`, and as columns of a run's `progress.csv`. Training goes on as if nothing
    had been measured. Of worlds that are not this suite's nothing is measured.

    Attributes:
        columns: names of the figures that are reported.
        metrics: those measured after the last rollout; mostly none.
    """

    columns = ("visible", "cadence_hz", "foot_height_m", "flight_share", "tempo_error_m", "world_error_m")

    def __init__(self, samples: int = 250_000, share: float = 0.03, seed: int = 0) -> None:
        """Choose how often.

        Args:
            samples: samples between two measurements, at least.
            share: share of the training's time that measuring may take; where it would take more, it comes later.
            seed: of the start states.
        """
        super().__init__()
        self.samples, self.share, self.seed = samples, share, seed
        self.metrics: dict[str, float] = {}

    def _init_callback(self) -> None:
        self._worlds: _StyleWorlds | None = None
        self._began, self._spent, self._last = time.monotonic(), 0.0, 0.0
        self._next = self.model.num_timesteps + self.samples

    def _on_step(self) -> bool:
        return True

    def _on_rollout_end(self) -> None:
        self.metrics = {}
        began = time.monotonic()
        if self.num_timesteps < self._next or self._spent + self._last > self.share * (began - self._began):
            return
        self._worlds = self._worlds or _StyleWorlds.like(self.training_env, self.model.policy, self.seed)
        self._next = self.num_timesteps + self.samples
        if self._worlds is not None:
            with ExitStack() as averages:  # what will be exported, not the latest weights
                for average in self._averages():
                    averages.enter_context(average.acting())
                self._report(self._worlds.measure(self.model.policy))
            self._last = time.monotonic() - began
            self._spent += self._last

    def _averages(self) -> list[WeightAverage]:
        return [one.average for one in _flat(self.locals.get("callback")) if isinstance(one, WeightAveraging)]

    def _report(self, figures: dict[str, Any]) -> None:
        numbers = {name: float(value) for name, value in figures.items() if isinstance(value, bool | int | float)}
        for name, value in numbers.items():
            self.logger.record(f"style/{name}", value)
        self.metrics = {name: numbers[name] for name in self.columns if name in numbers}

    def _on_training_end(self) -> None:
        if self._worlds is not None:
            self._worlds.env.close()


def _flat(callback: Any) -> Iterator[Any]:
    """A callback, or those of a list and of the lists within it: a progress bar puts one around another."""
    if isinstance(callback, CallbackList):
        for one in callback.callbacks:
            yield from _flat(one)
    else:
        yield callback


class _StyleWorlds:
    """Worlds of a task with what is the same at every measurement: the clip's gait and the base's error."""

    def __init__(self, env: AdaptVectorEnv, expected: Gait, base_error: float | None, seed: int) -> None:
        self.env, self.expected, self.base_error, self.seed = env, expected, base_error, seed

    @classmethod
    def like(cls, training: VecEnv, policy: Any, seed: int) -> "_StyleWorlds | None":
        """Worlds of the same task without a time limit; None if the training's are not of this suite."""
        native = training.unwrapped
        worlds = native.vector_env.unwrapped if isinstance(native, AdaptVecEnv) else None
        if not isinstance(worlds, AdaptVectorEnv):
            return None
        env = AdaptVectorEnv(worlds.worlds.spec, WORLDS, max_episode_steps=None, num_threads=1)
        expected = clip_gait(env.worlds.reference.clips[0], reference_speed(env), env.worlds.reference.model)
        return cls(env, expected, tempo_error_of_base(policy, env, seed), seed)

    def measure(self, policy: Any) -> dict[str, Any]:
        straight = record_straight(policy, self.env, None, self.seed)
        return style_figures(self.env, straight, self.base_error, self.expected).as_dict()
