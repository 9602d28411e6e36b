"""Progress of a run: a bar or lines, progress.csv, the learning curve."""

import csv
import sys
import time
from typing import Any

from stable_baselines3.common.callbacks import BaseCallback
from tqdm import tqdm

from sb3_adaptnet.callback import DiscriminatorRewardCallback
from sb3_adaptnet.zoo.curve import draw_curve
from sb3_adaptnet.zoo.run_folder import RunFolder

COLUMNS = (
    "samples",
    "seconds",
    "samples_per_second",
    "goal_reward",
    "imitation_reward",
    "falls_per_minute",
    "episode_length",
    "kl",
    "actor_lr",
    "discriminator_accuracy_reference",
    "discriminator_accuracy_simulated",
)
SHOWN = (
    ("goal", "goal_reward", "{:.3f}"),
    ("imitation", "imitation_reward", "{:+.3f}"),
    ("falls/min", "falls_per_minute", "{:.2f}"),
    ("length", "episode_length", "{:.0f}"),
)


class Progress(BaseCallback):
    """Reports every rollout: a bar on a terminal, a line a minute elsewhere, and a row of ``progress.csv``."""

    def __init__(
        self,
        folder: RunFolder,
        discriminators: DiscriminatorRewardCallback,
        seconds: float = 0.0,
        quiet: bool = False,
        line_seconds: float = 60.0,
    ) -> None:
        """Prepare.

        Args:
            folder: The run's.
            discriminators: Where the numbers come from.
            seconds: Training time that went before (of a resumed run).
            quiet: Neither bar nor lines.
            line_seconds: Time between two lines where there is no terminal.
        """
        super().__init__()
        self.folder, self.discriminators = folder, discriminators
        self.seconds, self.quiet, self.line_seconds = seconds, quiet, line_seconds
        self.rows: list[dict[str, Any]] = []

    def _init_callback(self) -> None:
        self._clock = time.monotonic()
        self._lined = -self.line_seconds
        self.rows = read_rows(self.folder, self.num_timesteps or self.model.num_timesteps)
        self._write_all()
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
        batch = self.model.n_steps * self.training_env.num_envs  # type: ignore[attr-defined]
        metrics = self.discriminators.metrics
        row = {"samples": self.num_timesteps, "seconds": round(self.seconds, 2)}
        row["samples_per_second"] = round(batch / max(spent, 1e-9), 1)
        row.update({name: metrics[name] for name in COLUMNS if name in metrics})
        self.logger.record("time/samples_per_second", row["samples_per_second"])
        self.rows.append(row)
        with self.folder.progress.open("a", newline="", encoding="utf-8") as stream:
            csv.DictWriter(stream, COLUMNS, restval="").writerow(row)
        self._show(row, now)

    def _show(self, row: dict[str, Any], now: float) -> None:
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

    def _write_all(self) -> None:
        with self.folder.progress.open("w", newline="", encoding="utf-8") as stream:
            writer = csv.DictWriter(stream, COLUMNS, restval="")
            writer.writeheader()
            writer.writerows(self.rows)


def read_rows(folder: RunFolder, up_to: int) -> list[dict[str, Any]]:
    """Rows of ``progress.csv`` up to a number of samples; later ones were lost with the process."""
    if not folder.progress.is_file():
        return []
    rows = []
    with folder.progress.open(newline="", encoding="utf-8") as stream:
        for texts in csv.DictReader(stream):
            try:
                row = {name: float(text) for name, text in texts.items() if name in COLUMNS and text}
            except (TypeError, ValueError):
                continue  # a line that a kill cut short
            if row.get("samples", up_to + 1) <= up_to:
                row["samples"] = int(row["samples"])
                rows.append(row)
    return rows
