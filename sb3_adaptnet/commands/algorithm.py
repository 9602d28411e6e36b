"""Which algorithm learns, through which world model, from the words of a command line."""

import argparse

from sb3_adaptnet.runs.experiment import ALGORITHMS
from sb3_adaptnet.world_model.world_file import has_world


def add_options(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the algorithm and its world model; `default` says what is taken where none is named."""
    words = f"svg learns through a world model, ppo from discriminators; default: {default}"
    parser.add_argument("--algo", choices=list(ALGORITHMS), help=words)
    parser.add_argument("--world-model", metavar="FILE", help="of svg; default: the one beside the base")


def algorithm_of(options: argparse.Namespace, default: str) -> str:
    """Name of the algorithm that the options of `add_options` ask for, or the default.

    Raises:
        ValueError: for a world model that the algorithm does not use.
    """
    algo: str = options.algo or default
    if options.world_model is not None and algo != "svg":
        raise ValueError(f"--world-model {options.world_model} goes with --algo svg, not with {algo}")
    return algo


def best_for(base: str) -> str:
    """Name of the algorithm that adapts a base to a style best: "svg" where the base has a world model.

    Raises:
        CheckpointError: if there is no such base.
    """
    return "svg" if has_world(base) else "ppo"


BEST = "svg where the base has a world model"
"""What `best_for` says, for people."""
