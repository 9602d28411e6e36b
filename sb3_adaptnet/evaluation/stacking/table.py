"""Cells of pairs as a Markdown table with one sentence for each kind of pair, and as CSV."""

import csv
import io
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

from sb3_adaptnet.evaluation.report import text_of
from sb3_adaptnet.evaluation.stacking.cells import ACTING, MOST_FALLS, Cell
from sb3_adaptnet.weights.atomic_file import write_atomically

Four = Sequence[Cell]
"""The cells of one pair, in the order of `cells.ACTING`."""
_COLUMNS = [item.name for item in fields(Cell)]
_SAID = {"": None, "True": True, "False": False}
"""What is written of whether a style is visible."""
_BETWEEN = "; "
"""Stands between the tests that failed."""
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
    writer = csv.DictWriter(text, _COLUMNS, lineterminator="\n")
    writer.writeheader()
    for cell in (cell for cells in pairs for cell in cells):
        writer.writerow(asdict(cell) | {"weights": weights_of(cell), "failed_tests": _BETWEEN.join(cell.failed_tests)})
    write_atomically(path, lambda stream: stream.write(text.getvalue().encode()))


def read_csv(path: Path) -> list[Four]:
    """What `write_csv` wrote.

    Raises:
        ValueError: if there is no such file, or it is no such table.
    """
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            reader = csv.DictReader(stream)
            if reader.fieldnames != _COLUMNS:
                raise ValueError(f"its columns are not {', '.join(_COLUMNS)}")
            cells = [_cell(row) for row in reader]
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from error
    except (ValueError, TypeError, AttributeError) as error:  # a cell that is none, or a row that is too short
        raise ValueError(f"{path} is no table of stacks: {' '.join(str(error).split())}") from error
    pairs = [cells[start : start + len(ACTING)] for start in range(0, len(cells), len(ACTING))]
    for pair in pairs:
        if tuple(cell.acting for cell in pair) != ACTING or len({_name([cell]) for cell in pair}) > 1:
            raise ValueError(f"{path} is no table of stacks: {_name(pair)} has not the rows {', '.join(ACTING)}")
    return list(pairs)


def _cell(row: dict[str, str]) -> Cell:
    if row["visible"] not in _SAID:
        raise ValueError(f"visible is {row['visible']!r}, and not True, False or empty")
    first, _, second = row["weights"].partition(" + ")
    return Cell(
        **{name: row[name] for name in ("first", "second", "kinds", "acting", "speeds")},
        weights=(float(first), float(second)),
        goal_reward=float(row["goal_reward"]),
        falls_per_minute=float(row["falls_per_minute"]),
        tempo_error_m=float(row["tempo_error_m"]) if row["tempo_error_m"] else None,
        visible=_SAID[row["visible"]],
        failed_tests=tuple(filter(None, row["failed_tests"].split(_BETWEEN))),
        seconds=float(row["seconds"]),
        seed=int(row["seed"]),
    )


def renewed(old: Sequence[Four], new: Sequence[Four]) -> list[Four]:
    """The old pairs, those that were measured again by their new cells, and what is new besides at the end."""
    return list(({_name(cells): cells for cells in old} | {_name(cells): cells for cells in new}).values())
