"""All runs of a sweep at one glance, from their folders alone: as lines of text, CSV or Markdown."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from sb3_adaptnet.runs.history import Row, read_rows
from sb3_adaptnet.sweeps.unit import Unit, UnitFolder

LAST_ROLLOUTS = 10
"""Rollouts that the figures of training are means of."""


@dataclass(frozen=True)
class RunStatus:
    """One row; the fields are the columns of the CSV file.

    Attributes:
        run: name of its folder.
        environment: what it trains on.
        override: name of the override; empty for none.
        seed: of the training.
        algo: the algorithm.
        samples: control steps done; of a run that is going on, also those since its last checkpoint.
        wanted: control steps asked for.
        state: "waiting", "running", "stopped", "failed" or "done".
        training_goal: goal reward of the last rollouts, with exploration; None before the first.
        training_falls: falls per minute in them.
        goal_reward: goal reward by the measurement at the end, mean over its seeds; None without one, as all below.
        falls_per_minute: its falls.
        tempo_error_m: its imitation error at about the clip's tempo [m].
        visible: whether the style is visible with every seed.
        seconds: simulated seconds with each seed.
        problem: why the last process failed, or that it started from weights that are others by now; empty otherwise.
    """

    run: str
    environment: str
    override: str
    seed: int
    algo: str
    samples: int
    wanted: int
    state: str
    training_goal: float | None
    training_falls: float | None
    goal_reward: float | None
    falls_per_minute: float | None
    tempo_error_m: float | None
    visible: bool | None
    seconds: float | None
    problem: str


COLUMNS = (
    ("run", "run", ""),
    ("samples", "samples", "{:,}"),
    ("of", "wanted", "{:,}"),
    ("training: goal", "training_goal", "{:.3f}"),
    ("falls/min", "training_falls", "{:.2f}"),
    ("measured: goal", "goal_reward", "{:.3f}"),
    ("falls/min", "falls_per_minute", "{:.2f}"),
    ("tempo error [m]", "tempo_error_m", "{:.3f}"),
    ("visible", "visible", ""),
    ("state", "state", ""),
)
"""Words, field and format of the columns for people."""


def read_status(folder: str | Path) -> list[RunStatus]:
    """The runs below a sweep's folder, by name.

    Raises:
        ValueError: if there are none.
    """
    places = [UnitFolder(file.parent) for file in sorted(Path(folder).glob("*/unit.yml"))]
    if not places:
        raise ValueError(f"there is no sweep in {folder}: it has no folders with a unit.yml")
    return [status_of(place) for place in places]


def status_of(place: UnitFolder) -> RunStatus:
    """One run's row."""
    unit, result, rows = place.read(), place.read_result(), read_rows(place.path / "progress.csv")
    last, state = rows[-LAST_ROLLOUTS:], place.state()
    figures = result.get("figures", []) if state == "done" else []
    return RunStatus(
        run=unit.name,
        environment=unit.settings.env_id,
        override=unit.override,
        seed=unit.settings.seed,
        algo=unit.settings.algo,
        samples=int(rows[-1]["samples"]) if rows else 0,
        wanted=unit.settings.samples,
        state=state,
        training_goal=mean(last, "goal_reward"),
        training_falls=mean(last, "falls_per_minute"),
        goal_reward=mean(figures, "goal_reward"),
        falls_per_minute=mean(figures, "falls_per_minute"),
        tempo_error_m=mean(figures, "tempo_error_m"),
        visible=None if any(one["visible"] is None for one in figures) or not figures else _all_visible(figures),
        seconds=mean(figures, "seconds"),
        problem=_problem(place, unit),
    )


def _problem(place: UnitFolder, unit: Unit) -> str:
    if place.failure.is_file():
        return place.failure.read_text(encoding="utf-8").strip()
    stale = f"{unit.after} has other weights than it started from; to do it again, remove its folder"
    return stale if place.is_stale() else ""


def _all_visible(figures: Sequence[Mapping[str, Any]]) -> bool:
    return all(one["visible"] for one in figures)


def mean(rows: Sequence[Row | Mapping[str, Any]], name: str) -> float | None:
    """Mean of a number that every row has; None if one has not, or there are no rows."""
    values = [row.get(name) for row in rows]
    numbers = [value for value in values if value is not None]
    return round(sum(numbers) / len(numbers), 4) if numbers and len(numbers) == len(values) else None


def csv_table(rows: Sequence[RunStatus]) -> str:
    """All fields of all runs as CSV; what is not there stays empty."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, [field.name for field in fields(RunStatus)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(row) for row in rows)
    return stream.getvalue().rstrip("\n")


def markdown_table(rows: Sequence[RunStatus]) -> str:
    """The columns for people as a Markdown table."""
    lines = [[words for words, _, _ in COLUMNS], ["---"] * len(COLUMNS), *map(cells, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def text_table(rows: Sequence[RunStatus]) -> str:
    """The columns for people as lines of text, then how many runs are in which state, and what went wrong."""
    lines = [[words for words, _, _ in COLUMNS], *map(cells, rows)]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    aligned = [
        "  ".join([line[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(line[1:], widths[1:], strict=True))])
        for line in lines
    ]
    return "\n".join([*aligned, summary(rows), *(f"{row.run}: {row.problem}" for row in rows if row.problem)])


def summary(rows: Sequence[RunStatus]) -> str:
    """How many runs are in which state."""
    counts = {state: sum(row.state == state for row in rows) for state in dict.fromkeys(row.state for row in rows)}
    return f"{len(rows)} runs: " + ", ".join(f"{count} {state}" for state, count in counts.items())


def cells(row: RunStatus) -> list[str]:
    """A run's texts; "-" where there is nothing."""
    return [_text(getattr(row, name), shape) for _, name, shape in COLUMNS]


def _text(value: Any, shape: str) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return "-" if value is None else shape.format(value) if shape else str(value)
