"""Which algorithm adapts a base to a style, from the words of a command line."""

import argparse

from sb3_adaptnet.runs.experiment import ALGORITHMS
from sb3_adaptnet.world_model.world_file import has_world


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the algorithm and its world model."""
    words = "svg learns through a world model, ppo from discriminators; default: svg where the base has a world model"
    parser.add_argument("--algo", choices=list(ALGORITHMS), help=words)
    parser.add_argument("--world-model", metavar="FILE", help="of svg; default: the one beside the base")


def algorithm_of(options: argparse.Namespace) -> str:
    """Name of the algorithm that the options of `add_options` and `base` ask for.

    Raises:
        ValueError: for a world model that the algorithm does not use.
        CheckpointError: if there is no such base.
    """
    if options.world_model is not None:
        if options.algo == "ppo":
            raise ValueError(f"--world-model {options.world_model} goes with --algo svg, not with ppo")
        return "svg"
    return options.algo or ("svg" if has_world(options.base) else "ppo")
