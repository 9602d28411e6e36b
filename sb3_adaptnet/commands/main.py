"""The command `adaptnet`: one parser; each subcommand has its file."""

import argparse
import os
import sys
from collections.abc import Sequence

import gymnasium as gym

from adapt_envs.commands import doctor, envs, motions
from sb3_adaptnet.commands import adapt, curves, demo, export, hub, play, stack, sweep, train, world_model
from sb3_adaptnet.commands import eval as evaluation
from sb3_adaptnet.commands.bench import env as bench_env
from sb3_adaptnet.commands.bench import train as bench_train

BAD_INPUT, PIPE_CLOSED = 2, 141
"""Exit codes; the latter is what shells have for it."""


def make_parser() -> argparse.ArgumentParser:
    """Build the parser of all subcommands; each stores the function that runs it as `run`."""
    parser = argparse.ArgumentParser(prog="adaptnet", description="AdaptNet for Gymnasium and Stable-Baselines3.")
    parser.add_argument("--traceback", action="store_true", help="show where an error came from")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    demo.add_parser(subparsers)
    train.add_parser(subparsers)
    adapt.add_parser(subparsers)
    sweep.add_parser(subparsers)
    evaluation.add_parser(subparsers)
    stack.add_parser(subparsers)
    play.add_parser(subparsers)
    export.add_parser(subparsers)
    hub.add_parser(subparsers)
    curves.add_parser(subparsers)
    world_model.add_parser(subparsers)
    envs.add_parser(subparsers)
    motions.add_parser(subparsers)
    doctor.add_parser(subparsers)
    bench_parser = subparsers.add_parser("bench", help="measure speed")
    benches = bench_parser.add_subparsers(dest="bench", required=True, metavar="WHAT")
    bench_env.add_parser(benches)
    bench_train.add_parser(benches)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: words after `adaptnet`; default `sys.argv`.

    Returns:
        Exit code: the subcommand's, or 2 after one sentence about bad input.
    """
    options = make_parser().parse_args(arguments)
    try:
        code = int(options.run(options) or 0)
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # whoever read the output, such as `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
    except (ValueError, OSError, gym.error.Error) as error:
        if options.traceback:
            raise
        print(f"adaptnet {options.command}: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT


if __name__ == "__main__":
    sys.exit(main())
