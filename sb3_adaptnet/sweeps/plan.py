"""From a sweep to its runs; everything is checked before anything is written."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym

from adapt_envs.motion.library import load_clip, ships
from adapt_envs.registration import spec_of
from sb3_adaptnet.algorithms.checks import NEW
from sb3_adaptnet.runs.experiment import (
    ALGORITHMS,
    Experiment,
    check_algorithm,
    conf_path,
    experiment_of,
    read_entry,
)
from sb3_adaptnet.runs.run_folder import RunSettings
from sb3_adaptnet.runs.yaml_values import whole
from sb3_adaptnet.sweeps.changes import merged
from sb3_adaptnet.sweeps.sweep_file import Sweep, Task
from sb3_adaptnet.sweeps.unit import Unit, UnitFolder
from sb3_adaptnet.weights.checkpoint import Base, check_base, read_adaptation, read_base, resolve
from sb3_adaptnet.world_model.world_file import beside_base, read_world

SETTINGS = ("algo", "base", "conf_file", "motion", "n_envs", "samples", "start", "world_model")
"""Changes that are settings of a run, as of `adaptnet train`; all others change the zoo's entry."""


def units_of(sweep: Sweep, cores: int) -> list[Unit]:
    """The runs of a sweep, in the file's order, seeds last.

    Args:
        sweep: what to train.
        cores: of this machine; what a run takes where the sweep does not say.

    Raises:
        ValueError: if anything asked for does not exist or does not fit, or two runs have the same name.
    """
    units: list[Unit] = []
    for task in sweep.tasks:
        for override, changes in sweep.overrides.items():
            where = f"{sweep.name}.yml: {task.name}{override and f' with {override}'}"
            try:
                units += _units(sweep, task, override, merged(task.changes, changes), cores, units)
            except (ValueError, TypeError, AssertionError, OSError, gym.error.Error) as error:
                raise ValueError(f"{where}: {error}") from error
    names = [unit.name for unit in units]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"{sweep.name}.yml: two runs are called {twice!r}; give a task another `name`")
    return units


def waves(units: Sequence[Unit]) -> list[list[str]]:
    """Names of the runs in groups: what a run starts from is in a group before its own."""
    number: dict[str, int] = {}
    for unit in units:
        number[unit.name] = number[unit.after] + 1 if unit.after else 0
    return [[name for name in number if number[name] == wave] for wave in range(max(number.values()) + 1)]


def prepare(units: Sequence[Unit], folder: Path) -> list[UnitFolder]:
    """Write every run's `unit.yml` below a folder, and return the runs' folders.

    Raises:
        ValueError: if a run there began with other settings; nothing is written then.
    """
    found = [(unit, UnitFolder(folder / unit.name)) for unit in units]
    for unit, place in found:
        if not place.unit_file.is_file() or not (place.begun or place.result.is_file()):
            continue
        before, now = place.read().fixed(), unit.fixed()
        changed = [name for name in {**before, **now} if before.get(name) != now.get(name)]
        if changed:
            name = changed[0]
            raise ValueError(
                f"{place.path} began with {name} {before.get(name)!r}, the sweep says {now.get(name)!r}; "
                f"remove that folder or choose another one with --dir"
            )
    for unit, place in found:
        place.write(unit)
    return [place for _, place in found]


def _units(
    sweep: Sweep, task: Task, override: str, changes: Mapping[str, Any], cores: int, before: Sequence[Unit]
) -> list[Unit]:
    given = _settings({key: value for key, value in changes.items() if key in SETTINGS})
    algo = check_algorithm(given.pop("algo", "ppo"))
    spec = spec_of(task.env_id)
    if sweep.measurement is not None and "task" not in spec.kwargs:
        raise ValueError(f"{task.env_id} is not of this suite and cannot be evaluated")
    entry = read_entry(conf_path(given.pop("conf_file", algo)), task.env_id)
    entry = merged(entry, {key: value for key, value in changes.items() if key not in SETTINGS})
    after = _run_of(given, before)
    found = experiment_of(entry, task.env_id, given.get("base"), algo, start=given.get("start") or after or None)
    samples = given.pop("samples", found.samples)
    given |= _files(found, given.get("motion"), given.get("world_model"), given.get("start"))
    resources = sweep.resources
    settings: dict[str, Any] = {
        "threads": resources.threads or max(round(resources.cpus or cores), 1),
        "device": "cuda" if resources.gpus else "cpu",
        "algo": algo,
        **given,
    }
    return [
        Unit(
            name="-".join(filter(None, (task.name, override, f"seed{seed}"))),
            task=task.name,
            override=override,
            settings=RunSettings(task.env_id, samples, seed, **settings),
            entry=entry,
            measurement=sweep.measurement,
            minutes=sweep.minutes,
            bits=task.bits,
            after=after,
        )
        for seed in task.seeds
    ]


def _run_of(given: dict[str, Any], before: Sequence[Unit]) -> str:
    """Take `start` out of settings and return that run's name if it is a task before this one, else ""."""
    runs = [unit.name for unit in before if unit.task == given.get("start")]
    if not runs:
        return ""
    if len(runs) > 1:
        raise ValueError(f"it starts from {given['start']!r}, of which there are {len(runs)} runs: {', '.join(runs)}")
    del given["start"]
    return runs[0]


def _settings(given: dict[str, Any]) -> dict[str, Any]:
    for name in ("samples", "n_envs"):
        if name in given:
            given[name] = whole(name, given[name], least=1)
    for name in given:
        if name not in ("samples", "n_envs") and not isinstance(given[name], str):
            raise ValueError(f"{name} is {given[name]!r}, expected a name or a file")
    return given


def _files(found: Experiment, motion: str | None, world_model: str | None, start: str | None) -> dict[str, str]:
    """Check what the run will open, and build what needs no worlds; return paths that hold in any working directory."""
    files: dict[str, str] = {}
    known: Base | None = None
    found.make_callbacks()
    base = found.arguments["policy_kwargs"].get("base")
    if base is not None:
        if not resolve(base).is_file():
            raise ValueError(f"there is no base file {str(resolve(base))!r}")
        known = read_base(base)
        files["base"] = str(Path(base).resolve()) if Path(base).is_file() else str(base)
    if start is not None:
        if not resolve(start).is_file():
            raise ValueError(f"it starts from {start!r}, which is neither a task before it nor a file")
        adaptation = read_adaptation(start)
        if known is not None:
            check_base(adaptation, known.name, known.hash)
        files["start"] = str(Path(start).resolve()) if Path(start).is_file() else start
    if world_model is not None and found.algorithm != "svg":
        raise ValueError(f"world_model {world_model!r} goes with algo svg, not with {found.algorithm}")
    given = found.arguments.get("world_model") if world_model is None else world_model
    model = Path(given) if given is not None else None if base is None else beside_base(base)
    if found.algorithm == "svg" and model is not None and given != NEW:
        if not model.is_file():
            raise ValueError(f"there is no world model {str(model)!r}")
        read_world(model)
    if world_model is not None:
        files["world_model"] = world_model if world_model == NEW else str(Path(world_model).resolve())
    if motion is not None:
        load_clip(motion)
        files["motion"] = motion if ships(motion) else str(Path(motion).resolve())
    algorithm: Any = ALGORITHMS[found.algorithm]
    algorithm(found.policy, None, device="cpu", _init_setup_model=False, **found.arguments)
    return files
