"""The learning curve as a picture."""

from collections.abc import Sequence
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sb3_adaptnet.zoo.run_folder import RunFolder, write_atomically

PANELS = (
    ("goal_reward", "goal reward"),
    ("imitation_reward", "imitation reward"),
    ("falls_per_minute", "falls per minute"),
    ("episode_length", "episode length [steps]"),
)


def draw_curve(rows: Sequence[dict[str, Any]], folder: RunFolder) -> None:
    """Draw the rows of ``progress.csv`` over samples into ``curve.png``."""
    if not rows:
        return
    figure = Figure(figsize=(10, 6), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, (column, label) in zip(figure.subplots(2, 2).flat, PANELS, strict=True):
        points = [(row["samples"] / 1e6, row[column]) for row in rows if column in row]
        axes.plot([x for x, _ in points], [y for _, y in points], linewidth=1.0)
        axes.set_xlabel("samples [million]")
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    settings = folder.settings
    figure.suptitle(f"{settings.env_id}, seed {settings.seed}")
    write_atomically(folder.curve, lambda stream: figure.savefig(stream, format="png", dpi=100))
