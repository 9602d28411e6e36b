"""Cells of pairs as a Markdown table with one sentence for each kind of pair, and as CSV."""

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

from sb3_adaptnet.evaluation.report import text_of
from sb3_adaptnet.evaluation.stacking.cells import MOST_FALLS, Cell
from sb3_adaptnet.weights.atomic_file import write_atomically

Four = Sequence[Cell]
"""The cells of one pair, in the order of `cells.ACTING`."""
_HEAD = ("stack", "weights", "falls per minute", "goal reward", "style error [m]", "style visible", "adds up")


def markdown(pairs: Sequence[Four]) -> str:
    """A sentence for each kind of pair, then one table; each cell of it reads base / first / second / both."""
    kinds = list(dict.fromkeys(cells[0].kinds for cells in pairs))
    lines = [sentence(kind, [cells for cells in pairs if cells[0].kinds == kind]) for kind in kinds]
    rows = [_HEAD, ("---",) * len(_HEAD), *(_row(cells) for cells in pairs)]
    return "\n".join([*lines, "", *(f"| {' | '.join(row)} |" for row in rows)])


def sentence(kinds: str, pairs: Sequence[Four]) -> str:
    """How many pairs of a kind add up."""
    good = [_name(cells) for cells in pairs if cells[-1].adds_up]
    bar = f"fall at most {MOST_FALLS:g} times a minute" + (" with the style visible" if "style" in kinds else "")
    named = f": {', '.join(good)}" if good else ""
    return f"{kinds}: {len(good)} of {len(pairs)} pairs {bar}{named}."


def _name(cells: Four) -> str:
    return f"{cells[0].first} + {cells[0].second}"


def weights_of(cell: Cell) -> str:
    """How strongly the two act, such as "1 + 1.2"."""
    return "{:g} + {:g}".format(*cell.weights)


def _row(cells: Four) -> tuple[str, ...]:
    def each(name: str, text: str) -> str:
        return " / ".join(text_of(getattr(cell, name), text) for cell in cells)

    adds_up = "**yes**" if cells[-1].adds_up else "no"
    figures = (each("falls_per_minute", "{:.1f}"), each("goal_reward", "{:.2f}"), each("tempo_error_m", "{:.3f}"))
    return _name(cells), weights_of(cells[-1]), *figures, each("visible", ""), adds_up


def write_csv(pairs: Sequence[Four], path: Path) -> None:
    """Write a row for every cell, four to a pair; the file appears whole."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [item.name for item in fields(Cell)], lineterminator="\n")
    writer.writeheader()
    for cell in (cell for cells in pairs for cell in cells):
        writer.writerow(asdict(cell) | {"weights": weights_of(cell), "failed_tests": "; ".join(cell.failed_tests)})
    write_atomically(path, lambda stream: stream.write(text.getvalue().encode()))
