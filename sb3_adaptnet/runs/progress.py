"""Progress of a run: a bar or lines, progress.csv, the learning curve."""

import sys
import time
from collections.abc import Sequence
from typing import Protocol, runtime_checkable

from stable_baselines3.common.callbacks import BaseCallback
from tqdm import tqdm

from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp
from sb3_adaptnet.runs.curve import draw_curve
from sb3_adaptnet.runs.history import Row, append_row, read_rows, reward_column, write_rows
from sb3_adaptnet.runs.run_folder import RunFolder

TIMES = ("samples", "seconds", "samples_per_second")
METRICS = (
    "falls_per_minute",
    "episode_length",
    "kl",
    "actor_lr",
    "discriminator_score_difference",
)
SHOWN = (
    ("goal", "goal_reward", "{:.3f}"),
    ("imitation", "imitation_reward", "{:+.3f}"),
    ("falls/min", "falls_per_minute", "{:.2f}"),
    ("length", "episode_length", "{:.0f}"),
    ("off by [m]", "tracking_error", "{:.3f}"),
)


class MetricsSource(Protocol):
    """What reports the numbers of every rollout.

    Attributes:
        objectives: names of the rewards.
        metrics: name -> mean over the last rollout.
    """

    objectives: tuple[str, ...]
    metrics: dict[str, float]


@runtime_checkable
class Measuring(Protocol):
    """A callback that measures something after some rollouts.

    Attributes:
        columns: names of what it measures.
        metrics: what it measured after the last rollout.
    """

    columns: tuple[str, ...]
    metrics: dict[str, float]


class RunProgress(BaseCallback):
    """Reports every rollout: a bar on a terminal, a line a minute elsewhere, and a row of `progress.csv`."""

    def __init__(
        self,
        folder: RunFolder,
        source: MetricsSource,
        ramps: Sequence[AttributeRamp] = (),
        measuring: Sequence[Measuring] = (),
        seconds: float = 0.0,
        quiet: bool = False,
        metrics: Sequence[str] = METRICS,
        line_seconds: float = 60.0,
    ) -> None:
        """Prepare.

        Args:
            folder: the run's.
            source: where the numbers come from.
            ramps: attributes of the worlds that change meanwhile; each gets a column.
            measuring: further callbacks with columns; they stand before this one.
            seconds: training time that went before (of a resumed run).
            quiet: neither bar nor lines.
            metrics: names of the source's numbers besides rewards; each gets a column.
            line_seconds: time between two lines where there is no terminal.
        """
        super().__init__()
        self.folder, self.source = folder, source
        self.seconds, self.quiet, self.line_seconds = seconds, quiet, line_seconds
        self.ramps, self.measuring, self.rows = ramps, measuring, list[Row]()
        rewards = [reward_column(name) for name in source.objectives]
        measured = [column for callback in measuring for column in callback.columns]
        self.columns = (*TIMES, *rewards, *metrics, *(ramp.attribute for ramp in ramps), *measured)

    def _init_callback(self) -> None:
        self._clock = time.monotonic()
        self._lined = -self.line_seconds
        # Later rows were lost with the process.
        self.rows = read_rows(self.folder.progress, self.num_timesteps or self.model.num_timesteps)
        # What was measured before and no longer is keeps its column.
        self.columns = tuple(dict.fromkeys([*self.columns, *(name for row in self.rows for name in row)]))
        write_rows(self.folder.progress, self.columns, self.rows)
        total = self.folder.settings.samples
        show_bar = sys.stderr.isatty() and not self.quiet
        self._bar = tqdm(total=total, unit=" samples", unit_scale=True, disable=not show_bar, dynamic_ncols=True)
        self._bar.update(self.model.num_timesteps)
        self._first = self.model.num_timesteps

    def _on_step(self) -> bool:
        self._bar.update(self.training_env.num_envs)
        return True

    def _on_rollout_end(self) -> None:
        now = time.monotonic()
        spent, self._clock = now - self._clock, now
        self.seconds += spent
        batch = self.model.n_steps * self.training_env.num_envs  # type: ignore[attr-defined]  # PPO and SVG have steps
        metrics = self.source.metrics
        row: Row = {"samples": self.num_timesteps, "seconds": round(self.seconds, 2)}
        row["samples_per_second"] = round(batch / max(spent, 1e-9), 1)
        row.update({name: metrics[name] for name in self.columns if name in metrics})
        row.update({ramp.attribute: ramp.value for ramp in self.ramps})
        for callback in self.measuring:
            row.update(callback.metrics)
        self.logger.record("time/samples_per_second", row["samples_per_second"])
        self.rows.append(row)
        append_row(self.folder.progress, self.columns, row)
        self._show(row, now)

    def _show(self, row: Row, now: float) -> None:
        shown = {label: text.format(row[name]) for label, name, text in SHOWN if name in row}
        self._bar.set_postfix(shown, refresh=False)
        if self.quiet or not self._bar.disable or now - self._lined < self.line_seconds:
            return
        self._lined = now
        total, speed = self.folder.settings.samples, row["samples_per_second"]
        left = (total - self.num_timesteps) / max(speed, 1e-9) / 60.0
        numbers = "  ".join(f"{label} {value}" for label, value in shown.items())
        print(f"{self.num_timesteps:>10,} of {total:,}  {speed:,.0f}/s  {left:.0f} min left  {numbers}", flush=True)

    def _on_training_end(self) -> None:
        self._bar.close()
        draw_curve(self.rows, self.folder)
