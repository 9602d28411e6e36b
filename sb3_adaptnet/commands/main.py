"""The command `adaptnet`: one parser; each subcommand has its file."""

import argparse
import importlib
import os
import sys
from collections.abc import Sequence

import gymnasium as gym

from adapt_envs.commands.exit_codes import BAD_INPUT, INTERRUPTED, PIPE_CLOSED

COMMANDS = {
    "demo": "sb3_adaptnet.commands.demo",
    "train": "sb3_adaptnet.commands.train",
    "adapt": "sb3_adaptnet.commands.adapt",
    "sweep": "sb3_adaptnet.commands.sweep",
    "eval": "sb3_adaptnet.commands.eval",
    "stack": "sb3_adaptnet.commands.stack",
    "play": "sb3_adaptnet.commands.play",
    "export": "sb3_adaptnet.commands.export",
    "pull": "sb3_adaptnet.commands.hub",
    "push": "sb3_adaptnet.commands.hub",
    "publish": "sb3_adaptnet.commands.hub",
    "curves": "sb3_adaptnet.commands.curves",
    "world-model": "sb3_adaptnet.commands.world_model",
    "envs": "adapt_envs.commands.envs",
    "motions": "adapt_envs.commands.motions",
    "doctor": "adapt_envs.commands.doctor",
    "bench": "sb3_adaptnet.commands.bench",
}
"""Subcommands and the modules that define them: a call reads its own alone, and starts the sooner for it."""


def make_parser(asked: str | None = None) -> argparse.ArgumentParser:
    """Build the parser of all subcommands, or of the one that is asked for; it stores the function that runs as `run`.

    Args:
        asked: word that should be a subcommand; another one, or None, means all.
    """
    parser = argparse.ArgumentParser(prog="adaptnet", description="AdaptNet for Gymnasium and Stable-Baselines3.")
    parser.add_argument("--traceback", action="store_true", help="show where an error came from")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in [COMMANDS[asked]] if asked in COMMANDS else dict.fromkeys(COMMANDS.values()):
        importlib.import_module(module).add_parser(subparsers)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: words after `adaptnet`; default `sys.argv`.

    Returns:
        Exit code: the subcommand's, or 2 after one sentence about bad input.
    """
    words = sys.argv[1:] if arguments is None else arguments
    asked = next((word for word in words if not word.startswith("-")), None)
    options = make_parser(asked).parse_args(words)
    try:
        code = int(options.run(options) or 0)
        sys.stdout.flush()
        return code
    except BrokenPipeError:  # whoever read the output, such as `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_CLOSED
    except KeyboardInterrupt:
        if options.traceback:
            raise
        print(f"adaptnet {options.command}: stopped", file=sys.stderr)
        return INTERRUPTED
    except (ValueError, OSError, gym.error.Error) as error:
        if options.traceback:
            raise
        print(f"adaptnet {options.command}: {' '.join(str(error).split())}", file=sys.stderr)
        return BAD_INPUT


if __name__ == "__main__":
    sys.exit(main())
