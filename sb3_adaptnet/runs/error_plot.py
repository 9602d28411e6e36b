"""How far a world model drifts, as a picture."""

from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from adapt_envs.drawing.palette import BLUE, GREY, RED, css
from sb3_adaptnet.weights.atomic_file import write_atomically
from sb3_adaptnet.world_model.fitting.error_table import ErrorTable


def draw_errors(model: ErrorTable, coasting: ErrorTable, path: Path, title: str = "") -> None:
    """Draw a model's errors over the horizon, and those of going on with the first velocities, into a PNG file."""
    figure = Figure(figsize=(8, 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    lines = (
        (coasting, "world", GREY, "--", "velocities stay: world frame"),
        (coasting, "heading", GREY, "-", "velocities stay: each in its own heading frame"),
        (model, "world", BLUE, "--", "model: world frame"),
        (model, "heading", RED, "-", "model: each in its own heading frame"),
    )
    for table, frame, colour, style, label in lines:
        axes.plot(table.steps, getattr(table, frame), style, color=css(colour), label=label)
    axes.set_yscale("log")
    axes.set_xlabel("control steps ahead, 1/30 s each")
    axes.set_ylabel("error of link positions [m]")
    axes.grid(alpha=0.3, which="both")
    axes.legend()
    figure.suptitle(title)
    write_atomically(path, lambda stream: figure.savefig(stream, format="png", dpi=100))
