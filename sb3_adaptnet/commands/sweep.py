"""`adaptnet sweep`: many runs from one file, and what has become of them."""

import argparse
import sys
from collections.abc import Collection
from pathlib import Path
from typing import Any

import torch
from filelock import Timeout

from adapt_envs.commands.doctor import usable_cores
from adapt_envs.commands.exit_codes import INTERRUPTED
from sb3_adaptnet.commands.export import export
from sb3_adaptnet.commands.policy_options import base_of, open_worlds_for
from sb3_adaptnet.evaluation.card import eval_command, write_evaluation
from sb3_adaptnet.evaluation.figures import evaluate
from sb3_adaptnet.policies.loading import load_policy
from sb3_adaptnet.runs.lock import lock_of
from sb3_adaptnet.runs.run_folder import RUNS, RunFolder
from sb3_adaptnet.runs.training import resume, start
from sb3_adaptnet.sweeps.attendant import ATTENDED, end_with_attendant
from sb3_adaptnet.sweeps.dispatch import check_room, has_ray, ray_libraries, run_by_ray, run_in_order
from sb3_adaptnet.sweeps.plan import prepare, units_of, waves
from sb3_adaptnet.sweeps.status import csv_table, markdown_table, read_status, summary, text_table
from sb3_adaptnet.sweeps.sweep_file import Sweep, read_sweep
from sb3_adaptnet.sweeps.unit import DONE, LOCK_SECONDS, Unit, UnitFolder
from sb3_adaptnet.weights.shipped import pretrained_names

NOT_ALL_DONE = 1
"""Exit code of a sweep with runs that failed."""
TRY_AGAIN = 75
"""Exit code of a run that the same command may well do later (EX_TEMPFAIL of sysexits.h)."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `sweep`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "sweep", help="train tasks x seeds x overrides from a YAML file, or show how far such a sweep is"
    )
    words = "the sweep's file, or a shipped one's name; `status DIR` shows its runs; `run DIR/RUN` does one of them"
    parser.add_argument("what", nargs="+", metavar="FILE.yml | status DIR", help=words)
    parser.add_argument("--dir", type=Path, metavar="DIR", help="folder of the runs; default runs/sweeps/NAME")
    parser.add_argument("--address", help="of a Ray cluster that shares the folder; default: this machine alone")
    parser.add_argument("--plain", action="store_true", help="one run after the other, even if Ray is installed")
    tables = parser.add_mutually_exclusive_group()
    tables.add_argument("--csv", action="store_true", help="status as CSV, with more columns")
    tables.add_argument("--markdown", action="store_true", help="status as a Markdown table")
    parser.add_argument(ATTENDED, action="store_true", help=argparse.SUPPRESS)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Sweep, show a sweep's state, or do one run.

    Raises:
        ValueError: for words that are none of these, or anything that cannot be as it is asked for.
    """
    _refuse_together(options)
    match options.what:
        case ["status", folder]:
            rows = read_status(folder)
            print(csv_table(rows) if options.csv else markdown_table(rows) if options.markdown else text_table(rows))
            return 0
        case ["run", folder]:
            return run_one(UnitFolder(folder), options.attended)
        case [file]:
            return run_all(read_sweep(file), options)
    words = " ".join(options.what)
    raise ValueError(f"{words!r} is no sweep; write FILE.yml, or: status DIR, or: run DIR/RUN")


def _refuse_together(options: argparse.Namespace) -> None:
    """Refuse options that would be ignored."""
    if options.plain and options.address is not None:
        raise ValueError("--plain does without Ray, and --address is that of a Ray cluster: leave out one of them")
    of_status, of_runs = ("csv", "markdown"), ("dir", "address", "plain")
    ignored = {"status": of_runs, "run": of_runs + of_status}.get(options.what[0], of_status)
    given = [f"--{name}" for name in ignored if getattr(options, name)]
    if given:
        raise ValueError(f"{given[0]} does not go with {' '.join(options.what)!r}")


def run_all(sweep: Sweep, options: argparse.Namespace) -> int:
    """Do what is not done yet; say what became of it."""
    units = units_of(sweep, cores := usable_cores())
    cpus, gpus = sweep.resources.cpus or cores, sweep.resources.gpus
    by_ray = not options.plain and (options.address is not None or has_ray())
    if by_ray:
        ray_libraries()  # before anything is written
    if options.address is None:
        check_room({"CPU": cores, "GPU": torch.cuda.device_count()}, cpus if by_ray else 0.0, gpus)
    folder = (options.dir or RUNS / "sweeps" / sweep.name).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with lock_of(folder).acquire(timeout=0):
            places = prepare(units, folder)
            waiting = [place.path for place in places if not place.is_done()]
            print(f"{len(places)} runs in {folder}, {len(places) - len(waiting)} of them done", flush=True)
            for wave in waves(units):
                now = [path for path in waiting if path.name in wave]
                if now and by_ray:
                    run_by_ray(now, sweep.retries, cpus, gpus, cores, options.address)
                elif now:
                    run_in_order(now, sweep.retries)
    except Timeout:
        raise ValueError(f"another sweep is at work in {folder}; look at it with: adaptnet sweep status") from None
    except KeyboardInterrupt:
        print(f"stopped; go on with the same command, or look with: adaptnet sweep status {folder}")
        return INTERRUPTED
    return report(folder, {place.path.name for place in places})


def report(folder: Path, names: Collection[str]) -> int:
    """Say how many of the runs of these names are done; the exit code is 1 if one is not."""
    rows = [row for row in read_status(folder) if row.run in names]
    print(f"{summary(rows)}; tables: adaptnet sweep status {folder} --markdown")
    for row in rows:
        if row.problem:
            print(f"{row.run}: {row.problem}; its log: {folder / row.run / 'log.txt'}")
    return 0 if all(row.state == DONE for row in rows) else NOT_ALL_DONE


def run_one(place: UnitFolder, attended: bool) -> int:
    """Train what is left of one run, then export and measure it.

    The exit code is 130 if it was stopped, and `TRY_AGAIN` if another process is at work in it or the system refused
    something, as a full disk does.

    Raises:
        ValueError: if it is no run of a sweep.
        FileNotFoundError: if a file that it needs is missing.
    """
    if attended:
        end_with_attendant()
    unit = place.read()
    try:
        with lock_of(place.path).acquire(timeout=LOCK_SECONDS):
            if train(place, unit) < unit.settings.samples:
                return INTERRUPTED
            finish(place, unit)
    except Timeout:
        print(f"another process is at work in {place.path}", file=sys.stderr)
        return TRY_AGAIN
    except FileNotFoundError:
        raise
    except OSError as error:
        print(error, file=sys.stderr)
        return TRY_AGAIN
    return 0


def train(place: UnitFolder, unit: Unit) -> int:
    """Begin a run or go on with it; return the samples in its checkpoint."""
    settings = unit.settings
    if place.begun:
        done = int(RunFolder.open(place.path).load()["samples"])
        if done >= settings.samples:
            return done
        print(f"goes on after {done} samples", flush=True)
        folder = resume(place.path, settings.samples, settings.device, settings.threads, minutes=unit.minutes)
    else:
        folder = start(place.write_config(unit), place.path, minutes=unit.minutes)
    return int(folder.load()["samples"])


def finish(place: UnitFolder, unit: Unit) -> None:
    """Export the weights of a trained run, measure them where that is asked for, and write down that it is done."""
    settings = unit.settings
    file = export(place.path, place.path / f"{unit.task}.safetensors", unit.bits)
    found = []
    if unit.measurement is not None:
        torch.set_num_threads(settings.threads or torch.get_num_threads())
        own = settings.env_id if ":" in settings.env_id else None  # a module's, which no card may name
        env = open_worlds_for(str(file), own, settings.motion if own else None, threads=settings.threads)
        policy, seconds = load_policy(file, env, base=settings.base), unit.measurement.seconds
        base = base_of(policy, str(file), env, settings.base)
        found = [evaluate(policy, env, seconds, seed, base=base).figures for seed in unit.measurement.seeds]
        env.close()
        options = {"env": own, "motion": settings.motion if own else None}
        options["base"] = None if settings.base in pretrained_names() else settings.base
        write_evaluation(file, found[0], eval_command(str(file), found[0], **options))
    samples = int(RunFolder.open(place.path).load()["samples"])
    place.write_result(unit, samples, file, [figures.as_dict() for figures in found])
