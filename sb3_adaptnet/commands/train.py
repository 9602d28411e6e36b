"""`adaptnet train`: train or adapt on an environment, resumable."""

import argparse
from collections.abc import Sequence
from typing import Any

from adapt_envs.commands.exit_codes import INTERRUPTED
from adapt_envs.commands.numbers import minutes_of, positive, seed_of
from sb3_adaptnet.commands.algorithm import add_options as add_algorithm_options
from sb3_adaptnet.commands.algorithm import algorithm_of
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.run_folder import RunFolder, RunSettings
from sb3_adaptnet.runs.training import resume, start

DEFAULT = "ppo"
"""The algorithm of a training for which none is named, as the paper's."""
FROM_SCRATCH_ONLY = ("seed", "algo", "conf_file", "base", "start", "world_model", "motion", "n_envs", "run_dir")
"""Options that a resumed run cannot change."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `train`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "train", help="train a base, or adapt one, as the zoo's YAML entry of the environment says"
    )
    parser.add_argument("env_id", metavar="ID", nargs="?", help="environment, as in AdaptNet/Humanoid-Stoop-v0")
    words = "YAML file with an entry for ID, or a shipped one's name (default: the algorithm's)"
    parser.add_argument("--conf-file", help=words)
    add_algorithm_options(parser, DEFAULT)
    parser.add_argument("--samples", type=positive, help="control steps over all worlds; default: the entry's")
    parser.add_argument("--seed", type=seed_of, help="default 0")
    parser.add_argument("--resume", metavar="RUN", help="go on with the run in this folder")
    parser.add_argument("--run-dir", metavar="DIR", help="folder of the new run; default runs/ID_N")
    parser.add_argument("--n-envs", type=positive, help="worlds; default: the entry's")
    parser.add_argument("--threads", type=positive, help="threads of physics and networks; default: all cores")
    parser.add_argument("--device", help="cpu (default) or cuda")
    parser.add_argument("--base", metavar="NAME_OR_FILE", help="base to adapt; default: the entry's")
    words = "adaptation of that base to go on from, with this run's settings and learner"
    parser.add_argument("--start", metavar="NAME_OR_FILE", help=words)
    parser.add_argument("--motion", metavar="FILE", help="clip for environments that take motion=")
    parser.add_argument("--minutes", type=minutes_of, default=3.0, help="minutes between checkpoints (default 3)")
    parser.add_argument("--quiet", action="store_true", help="show no progress")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Train, then say where the run is."""
    shown = {"minutes": options.minutes, "quiet": options.quiet}
    if options.resume is not None:
        refuse_changes(options)
        folder = resume(options.resume, options.samples, options.device, options.threads, **shown)
    else:
        folder = start(settings_of(options), options.run_dir, **shown)
    return report(folder)


def settings_of(options: argparse.Namespace) -> RunSettings:
    """Settings of a new run.

    Raises:
        ValueError: if the id is missing or has no entry, or a world model is given to PPO.
    """
    if options.env_id is None:
        raise ValueError("name an environment, as in AdaptNet/Humanoid-Stoop-v0, or a run with --resume")
    algo = algorithm_of(options, DEFAULT)
    entry = experiment(options.env_id, options.base, options.conf_file, algo, options.start)
    return RunSettings(
        env_id=options.env_id,
        samples=options.samples or entry.samples,
        seed=options.seed or 0,
        conf_file=options.conf_file,
        base=options.base,
        motion=options.motion,
        n_envs=options.n_envs,
        device=options.device or "cpu",
        threads=options.threads,
        algo=algo,
        world_model=options.world_model,
        start=options.start,
    )


def refuse_changes(options: argparse.Namespace) -> None:
    """Refuse options that a resumed run cannot change.

    Raises:
        ValueError: if one was given, or the id is another.
    """
    refuse_given(options, FROM_SCRATCH_ONLY)
    asked, has = options.env_id, RunFolder.open(options.resume).settings.env_id
    if asked is not None and asked != has:
        raise ValueError(f"the run {options.resume} trains on {has}, not {asked}")


def refuse_given(options: argparse.Namespace, names: Sequence[str]) -> None:
    """Refuse options of a new run where one is resumed.

    Raises:
        ValueError: if one of these was given.
    """
    given = [name for name in names if getattr(options, name) is not None]
    if given:
        option = given[0].replace("_", "-")
        raise ValueError(f"--{option} cannot change in a resumed run; --samples, --device and --threads can")


def report(folder: RunFolder) -> int:
    """Say where the run is and how to go on; the exit code is 130 if it was interrupted."""
    done, asked = folder.load()["samples"], folder.settings.samples
    print(f"{done:,} samples in {folder.path} (checkpoint.pt, progress.csv, curve.png)")
    if done < asked:
        print(f"stopped before {asked:,}; go on with: adaptnet train --resume {folder.path}")
        return INTERRUPTED
    print(f"write its weights with: adaptnet export {folder.path} -o NAME.safetensors")
    return 0
