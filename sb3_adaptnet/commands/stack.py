"""`adaptnet stack`: pairs of adaptations in the world of both, each alone and both at once."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch

from adapt_envs.commands.numbers import positive, seconds_of, seed_of
from adapt_envs.commands.output import check_output
from sb3_adaptnet.commands.policy_options import ProgressBar
from sb3_adaptnet.evaluation.stacking import Cell, markdown, measure_pairs, read_csv, renewed, write_csv, write_heat_map
from sb3_adaptnet.stacking import pairs_of

STACK_SECONDS = 200.0
"""Simulated seconds of a cell."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `stack`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "stack", help="measure pairs of adaptations, each alone and both at once, in the world of both"
    )
    words = "adaptations of which pairs are made: names or files; default: all that ship"
    parser.add_argument("adaptations", nargs="*", metavar="ADAPTATION", help=words)
    words = "simulated seconds of each of a pair's four cells (default 200)"
    parser.add_argument("--seconds", type=seconds_of, default=STACK_SECONDS, help=words)
    parser.add_argument("--seed", type=seed_of, default=0, help="of start states and goals (default 0)")
    parser.add_argument("--threads", type=positive, help="threads of networks and physics; default: all cores")
    words = "random goals at the base's speeds, which grounds were trained at; default: at the style's"
    parser.add_argument("--base-speeds", action="store_true", help=words)
    words = "find how strongly each acts in the sum: another seed, seven choices at most, about a minute a pair"
    parser.add_argument("--find-weights", action="store_true", help=words)
    table = parser.add_mutually_exclusive_group()
    table.add_argument("--csv", type=Path, metavar="FILE.csv", help="write every cell, after each pair")
    words = "the same into a table of before, whose other pairs stay, are printed and drawn"
    table.add_argument("--into", type=Path, metavar="FILE.csv", help=words)
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.png", help="draw one heat map")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure all pairs; print a Markdown table.

    Raises:
        ValueError: for files that cannot be written, a table of before that is none, or adaptations that are none or of
            which no two go together.
    """
    table = options.into or options.csv
    for path, suffix in ((table, ".csv"), (options.output, ".png")):
        if path is not None:
            check_output(path, suffix)
    # A table of before is whole until all is measured anew: a run that is stopped loses nothing.
    before = read_csv(table) if table is not None and (options.into or table.is_file()) else []
    if options.threads is not None:
        torch.set_num_threads(options.threads)
    pairs, bar = pairs_of(options.adaptations), ProgressBar("walking")
    asked = (options.seconds, options.seed, options.threads, bar, options.base_speeds, options.find_weights)
    measured: list[Sequence[Cell]] = []
    for cells in measure_pairs(ProgressBar(f"{len(pairs)} pairs")(pairs), *asked):
        measured = renewed(measured, [cells])
        if table is not None:
            write_csv(renewed(before, measured), table)
    whole = renewed(before, measured) if options.into else measured
    if options.csv is not None:
        write_csv(whole, options.csv)
    if options.output is not None:
        write_heat_map(whole, options.output)
    print(markdown(whole))
    return 0
