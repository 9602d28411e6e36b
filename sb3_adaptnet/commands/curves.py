"""`adaptnet curves`: the learning curves of several runs in one picture."""

import argparse
from pathlib import Path
from typing import Any

from adapt_envs.commands.output import check_output
from sb3_adaptnet.runs.curve import draw_curves
from sb3_adaptnet.runs.history import Row, read_rows
from sb3_adaptnet.runs.run_folder import RunFolder


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `curves`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "curves", help="draw the learning curves of several runs into one picture"
    )
    words = "folder of a run, or a progress.csv; NAME=RUN names it in the legend"
    parser.add_argument("runs", nargs="+", metavar="RUN", help=words)
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE.png", help="where to")
    parser.add_argument("--title", default="", help="line above the picture")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Draw, and say where the picture is.

    Raises:
        ValueError: if a run does not exist or has no rows, two have the same name, or the file cannot be written.
    """
    check_output(options.output, ".png")
    histories: dict[str, list[Row]] = {}
    for text in options.runs:
        name, file = named(text)
        if name in histories:
            raise ValueError(f"two runs are called {name!r}; write NAME={file}")
        histories[name] = rows_of(file)
    draw_curves(histories, options.output, options.title)
    print(options.output)
    return 0


def named(text: str) -> tuple[str, str]:
    """Name and place of NAME=RUN; a bare RUN is called by its last part."""
    name, equals, place = text.partition("=")
    return (name, place) if equals else (Path(text).stem, text)


def rows_of(place: str) -> list[Row]:
    """Rows of a run's folder or of a CSV file.

    Raises:
        ValueError: if there are none.
    """
    file = Path(place) if Path(place).is_file() else RunFolder.open(place).progress
    rows = read_rows(file)
    if not rows:
        raise ValueError(f"{file} holds no rows of a training run; it needs the column 'samples'")
    return rows
