"""What training reported, rollout by rollout: the rows of `progress.csv`."""

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

from sb3_adaptnet.weights.atomic_file import write_atomically

Row = dict[str, float]


def reward_column(objective: str) -> str:
    """Name of the column of an objective's mean reward."""
    return f"{objective}_reward"


def write_rows(path: Path, columns: Sequence[str], rows: Iterable[Row]) -> None:
    """Write a file with a header, whole or not at all; a row's missing numbers stay empty."""
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, columns, restval="", extrasaction="ignore")
    writer.writeheader()
    writer.writerows(rows)
    write_atomically(path, lambda stream: stream.write(text.getvalue().encode()))


def append_row(path: Path, columns: Sequence[str], row: Row) -> None:
    """Append one row to a file that has these columns."""
    with path.open("a", newline="", encoding="utf-8") as stream:
        csv.DictWriter(stream, columns, restval="").writerow(row)


def read_rows(path: Path, up_to: float = float("inf")) -> list[Row]:
    """Rows with at most `up_to` samples; none where there is no file. A row that a kill cut short is left out."""
    if not path.is_file():
        return []
    rows = []
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            whole = [line for line in stream if line.endswith("\n")]
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not a CSV file: {error}") from error
    for texts in csv.DictReader(whole):
        try:
            row = {name: float(text) for name, text in texts.items() if text}
            row["samples"] = int(row["samples"])
        except (TypeError, ValueError, OverflowError, KeyError):
            continue
        if row["samples"] <= up_to:
            rows.append(row)
    return rows
