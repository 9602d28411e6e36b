"""`adaptnet pull`, `push` and `publish`: weights from the Hugging Face Hub, to it, and ready for it."""

import argparse
import sys
import tempfile
from filecmp import cmp
from functools import partial
from pathlib import Path
from shutil import copyfileobj
from typing import Any

from adapt_envs import AdaptVectorEnv
from sb3_adaptnet.commands.policy_options import open_worlds_for
from sb3_adaptnet.evaluation.recording import Acting
from sb3_adaptnet.hub import parse_address
from sb3_adaptnet.hub.download import WANTED
from sb3_adaptnet.policies.loading import base_of_adaptation, load_policy
from sb3_adaptnet.publishing import Publication, publishable_card, upload, write_folder
from sb3_adaptnet.weights.atomic_file import write_atomically
from sb3_adaptnet.weights.checkpoint import ADAPTATION, read_kind, resolve
from sb3_adaptnet.weights.shipped import pretrained_names, pretrained_path

OUR_LICENSE = "mit"
"""Licence of what ships."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommands `pull`, `push` and `publish`."""
    _add_pull(subparsers)
    _add_push(subparsers)
    _add_publish(subparsers)


def _add_pull(subparsers: Any) -> None:
    parser = subparsers.add_parser("pull", help="get weights from the Hugging Face Hub, and check them")
    parser.add_argument("address", metavar="ADDRESS", help="hf://OWNER/NAME, with @REVISION or /FILE if need be")
    words = "copy weights, card, clip and base into a folder; default: they stay in the Hub's cache"
    parser.add_argument("-o", "--output", type=Path, metavar="FOLDER", help=words)
    parser.set_defaults(run=run_pull)


def _add_push(subparsers: Any) -> None:
    parser = subparsers.add_parser("push", help="put weights, model card, picture and film onto the Hugging Face Hub")
    parser.add_argument("source", metavar="SOURCE", help="name or file of weights, or a folder of `adaptnet publish`")
    parser.add_argument("address", metavar="ADDRESS", help="where to, hf://OWNER/NAME")
    parser.add_argument("--private", action="store_true", help="a new repository is for its owner only")
    _add_words(parser)
    parser.set_defaults(run=run_push)


def _add_publish(subparsers: Any) -> None:
    parser = subparsers.add_parser("publish", help="write folders that are ready to push, one for each weight file")
    parser.add_argument("names", nargs="*", metavar="NAME|FILE", help="default: all weights that ship")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER", help="they appear in here")
    parser.add_argument("--owner", required=True, help="account or organisation on the Hub, which the cards name")
    _add_words(parser)
    parser.set_defaults(run=run_publish)


def _add_words(parser: argparse.ArgumentParser) -> None:
    words = "where an adaptation's base lies on the Hub; default: with the same owner, under the base's name"
    parser.add_argument("--base-model", metavar="OWNER/NAME", help=words)
    words = f"licence as the Hub abbreviates it; default: {OUR_LICENSE} for what ships, else none is named"
    parser.add_argument("--license", metavar="ID", help=words)
    parser.add_argument("--no-pictures", action="store_true", help="leave out picture and film, which need OpenGL")


def run_pull(options: argparse.Namespace) -> int:
    """Fetch, check, copy if asked to, and say how to go on."""
    address = parse_address(options.address)
    file = resolve(str(address))
    base = base_of_adaptation(file) if read_kind(file) == ADAPTATION else None
    if options.output is not None:
        file = _copy(file, base, options.output)
    print(f"wrote {file}" if options.output is not None else f"in the cache: {file}")
    print(f"go on with: adaptnet eval {file if options.output is not None else address}")
    return 0


def _copy(file: Path, base: Path | None, folder: Path) -> Path:
    """Copy what lies beside a weight file in the cache, and its base unless that ships; return the weight file."""
    found = {path.name: path for pattern in WANTED for path in file.parent.glob(pattern)}
    if base is not None and (base.stem not in pretrained_names() or base != pretrained_path(base.stem)):
        found |= {path.name: path for path in (base, base.with_suffix(".json")) if path.is_file()}
    there = {name: folder / name for name in found if (folder / name).exists()}
    taken = next((name for name, copy in there.items() if not cmp(found[name], copy, shallow=False)), None)
    if taken is not None:
        raise ValueError(f"{folder / taken} is there already; choose another folder with -o")
    folder.mkdir(parents=True, exist_ok=True)
    last = found.pop(file.name)
    for path in (*found.values(), last):
        with path.open("rb") as content:
            write_atomically(folder / path.name, partial(copyfileobj, content))
    return folder / file.name


def run_push(options: argparse.Namespace) -> int:
    """Upload a folder, or one that is made of weights for this."""
    address = parse_address(options.address)
    if address.file is not None:
        raise ValueError(f"{address}: a whole repository is pushed; leave out the file")
    if Path(options.source).is_dir():
        given = {"--base-model": options.base_model, "--license": options.license, "--no-pictures": options.no_pictures}
        if words := [name for name, value in given.items() if value]:
            raise ValueError(f"{words[0]} is for weights; {options.source} is a folder that is ready as it is")
        print(upload(Path(options.source), address, options.private))
        return 0
    with tempfile.TemporaryDirectory() as parent:
        folder = _publish(options, options.source, address.repo, Path(parent) / address.repo.partition("/")[2])
        print(upload(folder, address, options.private))
    return 0


def run_publish(options: argparse.Namespace) -> int:
    """Write the folders and say where they are and how to push one."""
    names = options.names or pretrained_names()
    files = [_checked(options, name) for name in names]  # a wrong one is found before the first picture
    repos = [parse_address(f"{options.owner}/{file.stem}").repo for file in files]
    for name, file, repo in zip(names, files, repos, strict=True):
        folder = _publish(options, name, repo, options.output / file.stem)
        print(f"wrote {folder}; push it with: adaptnet push {folder} hf://{repo}", flush=True)
    return 0


def _checked(options: argparse.Namespace, name: str) -> Path:
    """The weight file, whose card says enough for what is asked for."""
    environment = publishable_card(file := resolve(name))["environment"]
    if ":" in environment and not options.no_pictures:
        words = "a module's own, which would run for picture and film; leave them out with --no-pictures"
        raise ValueError(f"{file}: was trained in {environment!r}, {words}")
    return file


def _publish(options: argparse.Namespace, name: str, repo: str, folder: Path) -> Path:
    ours = OUR_LICENSE if name in pretrained_names() else None
    publication = Publication(_checked(options, name), repo, options.base_model, options.license or ours)
    if options.no_pictures:
        return write_folder(publication, folder)
    print(f"filming {name} ...", file=sys.stderr, flush=True)
    return write_folder(publication, folder, _acting(name))


def _acting(name: str) -> tuple[Acting, AdaptVectorEnv]:
    env = open_worlds_for(name, num_worlds=1, threads=1)
    return load_policy(name, env), env
