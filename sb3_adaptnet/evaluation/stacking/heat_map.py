"""All pairs as one heat map: falls by colour, and in each cell what else was measured."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from adapt_envs.drawing.palette import BLUE, INK, PAPER, css
from sb3_adaptnet.evaluation.stacking.cells import ACTING, Cell
from sb3_adaptnet.evaluation.stacking.table import weights_of
from sb3_adaptnet.weights.atomic_file import write_atomically

_MOST = 60.0
"""Falls per minute of the darkest cell."""
_WIDTH, _HEIGHT, _LEFT, _ABOVE, _LEGEND = 0.82, 0.68, 1.9, 0.8, 0.4
"""Size of a cell, and the room for names at its left, for titles above and below a block, and for the legend [inches].
"""
_NARROWEST = 6.4
"""Width of a picture whose legend is wider than its cells [inches]."""
_GAP = 0.4
"""Room between the cells of two pairs, in cells."""
_DARK = 20.0
"""Falls per minute from which a cell's text is light."""


def write_heat_map(pairs: Sequence[Sequence[Cell]], path: str | Path) -> None:
    """Write a PNG: a block for each kind of first adaptation, a row for each of them, four cells for each pair.

    Args:
        pairs: cells of each pair, in the order of `ACTING`.
        path: the file; its folder must exist.
    """
    blocks: dict[str, list[Sequence[Cell]]] = {}
    for cells in pairs:
        blocks.setdefault(cells[0].kinds.split(" + ")[0], []).append(cells)
    sides = [(len({c[0].first for c in block}), len({c[0].second for c in block})) for block in blocks.values()]
    widest = _LEFT + _WIDTH * max((len(ACTING) + _GAP) * columns for _, columns in sides)  # the last gap is a margin
    width = max(widest, _NARROWEST)
    heights = [_ABOVE + _HEIGHT * rows for rows, _ in sides]
    whole = sum(heights) + _LEGEND
    figure = Figure(figsize=(width, whole), dpi=110, facecolor=css(PAPER))
    canvas = FigureCanvasAgg(figure)
    below = whole
    for (rows, columns), block, height in zip(sides, blocks.values(), heights, strict=True):
        below -= height
        across = _WIDTH * ((len(ACTING) + _GAP) * columns - _GAP)
        place = (_LEFT / width, (below + 0.35) / whole, across / width, _HEIGHT * rows / whole)
        _draw_block(figure.add_axes(place), block)
    words = "colour, first line: falls per minute; second: goal reward;\nthird: error to the style's clip [cm], "
    figure.text(
        0.1 / width,
        0.1 / whole,
        f"{words}v: the style is visible; fourth: weights, if found; framed: adds up",
        fontsize=8,
    )
    write_atomically(Path(path), canvas.print_png)


def _draw_block(axes: Axes, block: Sequence[Sequence[Cell]]) -> None:
    firsts = list(dict.fromkeys(cells[0].first for cells in block))
    seconds = list(dict.fromkeys(cells[0].second for cells in block))
    wide = len(ACTING) + _GAP
    norm, colours = PowerNorm(0.4, 0, _MOST, clip=True), "YlOrRd"
    for cells in block:
        row, column = firsts.index(cells[0].first), seconds.index(cells[0].second) * wide
        falls = np.array([[cell.falls_per_minute for cell in cells]])
        axes.imshow(falls, extent=(column, column + len(cells), row + 1, row), norm=norm, cmap=colours, aspect="auto")
        for i, cell in enumerate(cells):
            light = cell.falls_per_minute > _DARK
            axes.text(
                column + i + 0.5, row + 0.5, _words(cell), ha="center", va="center", fontsize=7.5,
                color=css(PAPER if light else INK), fontweight="bold" if i == len(cells) - 1 else "normal",
            )  # fmt: skip
        if cells[-1].adds_up:
            last = column + len(cells) - 0.97
            axes.add_patch(Rectangle((last, row + 0.03), 0.94, 0.94, fill=False, edgecolor=css(BLUE), linewidth=2.5))
    axes.set(xlim=(0, wide * len(seconds) - _GAP), ylim=(len(firsts), 0))
    axes.set_yticks(np.arange(len(firsts)) + 0.5, firsts)
    heads = list(ACTING) * len(seconds)
    axes.set_xticks([wide * k + i + 0.5 for k in range(len(seconds)) for i in range(len(ACTING))], heads, fontsize=8)
    for k, second in enumerate(seconds):
        axes.text(wide * k + len(ACTING) / 2, -0.12, f"+ {second}", ha="center", va="bottom", fontsize=11)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    axes.set_facecolor(css(PAPER))


def _words(cell: Cell) -> str:
    """Falls, goal reward, the style's error with a mark where it is visible, and weights of a sum that has others."""
    lines = [f"{cell.falls_per_minute:.1f}", f"{cell.goal_reward:.2f}"]
    if cell.visible is not None:
        error = "-" if cell.tempo_error_m is None else f"{100 * cell.tempo_error_m:.1f}"
        lines.append(f"{error} v" if cell.visible else error)
    if cell.acting == ACTING[-1] and cell.weights != (1.0, 1.0):
        lines.append(weights_of(cell))
    return "\n".join(lines)
