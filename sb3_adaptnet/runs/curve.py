"""Learning curves as a picture."""

from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from adapt_envs.drawing.palette import SERIES, css
from sb3_adaptnet.runs.history import Row
from sb3_adaptnet.runs.run_folder import RunFolder
from sb3_adaptnet.weights.atomic_file import write_atomically

FALLS, LENGTH = "falls_per_minute", "episode_length"
SCORES, TEMPO_ERROR = "discriminator_score_difference", "tempo_error_m"
LABELS = {
    FALLS: "falls per minute",
    LENGTH: "episode length [steps]",
    SCORES: "discriminators' scores, clip - policy",
    TEMPO_ERROR: "tempo error of the mean action [m]",
}
WINDOW = 15
"""Number of rollouts that the strong line averages."""


def draw_curve(rows: Sequence[Row], folder: RunFolder) -> None:
    """Draw a run's rows over samples into its `curve.png`."""
    if rows:
        settings = folder.settings
        draw_curves({"": rows}, folder.curve, f"{settings.env_id}, seed {settings.seed}")


def draw_curves(histories: Mapping[str, Sequence[Row]], path: Path, title: str = "") -> None:
    """Draw the rewards, falls and episode lengths of one run or several over their samples.

    Args:
        histories: name of a run, shown in the legend, to its rows.
        path: PNG file; its folder must exist.
        title: line above.
    """
    columns = panels(histories)
    figure = Figure(figsize=(10, 3 * -(-len(columns) // 2)), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(-(-len(columns) // 2), 2, squeeze=False).flat
    for column, axes in zip(columns, grid, strict=False):  # in this order zip leaves `grid` at the next
        for (name, rows), colour in zip(histories.items(), cycle(map(css, SERIES)), strict=False):
            points = np.array([(row["samples"] / 1e6, row[column]) for row in rows if column in row]).reshape(-1, 2)
            axes.plot(*points.T, linewidth=0.6, alpha=0.35, color=colour)
            mean, marker = (points[:, 1], "o") if column == TEMPO_ERROR else (moving_mean(points[:, 1]), None)
            axes.plot(points[:, 0], mean, linewidth=1.4, marker=marker, color=colour, label=name)
        axes.set_xlabel("samples [million]")
        axes.set_ylabel(LABELS.get(column, column.replace("_", " ")))
        axes.grid(alpha=0.3)
    for axes in list(grid):  # an odd number of panels leaves one over
        axes.set_axis_off()
    if len(histories) > 1:
        figure.axes[0].legend()
    figure.suptitle(title)
    write_atomically(path, lambda stream: figure.savefig(stream, format="png", dpi=100))


def panels(histories: Mapping[str, Sequence[Row]]) -> list[str]:
    """Columns that are drawn: every objective's reward, falls and length; scores and tempo error where measured."""
    found = dict.fromkeys(column for rows in histories.values() for row in rows for column in row)
    return [
        *(column for column in found if column.endswith("_reward")),
        FALLS,
        LENGTH,
        *(c for c in (SCORES, TEMPO_ERROR) if c in found),
    ]


def moving_mean(values: NDArray[np.floating], window: int = WINDOW) -> NDArray[np.floating]:
    """Mean of up to `window` values around each; shorter at both ends."""
    if not len(values):
        return values
    ones = np.ones(min(window, len(values)))
    return np.convolve(values, ones, "same") / np.convolve(np.ones(len(values)), ones, "same")
