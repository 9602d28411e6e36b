"""`adaptnet envs`: the environments as a list, as a table and as a picture."""

import argparse

from tqdm import tqdm

from adapt_envs.commands.gallery import snapshot, write_gallery
from adapt_envs.commands.output import check_output
from adapt_envs.registration import env_id
from adapt_envs.suite import SUITE, find


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the subcommand `envs`."""
    parser = subparsers.add_parser("envs", help="list and draw the environments")
    commands = parser.add_subparsers(dest="envs", required=True, metavar="WHAT")
    listing = commands.add_parser("list", help="print every id with a sentence about it")
    listing.set_defaults(run=run_list)
    sheet = commands.add_parser("sheet", help="draw a contact sheet of the environments")
    sheet.add_argument("-o", "--output", default="environments.png", help="PNG file to write")
    sheet.add_argument("names", nargs="*", help="names, such as LongShins; all if none is given")
    sheet.set_defaults(run=run_sheet)


def run_list(arguments: argparse.Namespace) -> int:
    """Print ids and summaries."""
    del arguments
    for name, spec in SUITE.items():
        print(f"{env_id(name):48s}{spec.summary}")
    return 0


def run_sheet(arguments: argparse.Namespace) -> int:
    """Write the contact sheet."""
    check_output(arguments.output, ".png")
    names = arguments.names or list(SUITE)
    for name in names:
        find(name)
    progress = tqdm(names, desc="drawing", disable=None)
    write_gallery(arguments.output, names, (snapshot(name) for name in progress))
    print(arguments.output)
    return 0
