"""`adaptnet bench`: one file for each thing whose speed it measures."""

from typing import Any

from sb3_adaptnet.commands.bench import env, train


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `bench` and what it measures."""
    parser = subparsers.add_parser("bench", help="measure speed")
    benches = parser.add_subparsers(dest="bench", required=True, metavar="WHAT")
    env.add_parser(benches)
    train.add_parser(benches)
