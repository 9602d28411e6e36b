"""Sweeps as YAML files: what to train, with which seeds and changes, on how much of a machine."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from sb3_adaptnet.runs.experiment import LOADER
from sb3_adaptnet.runs.yaml_values import label, mapping, number, one_of, seeds, whole
from sb3_adaptnet.weights.shipped import sweep_path
from sb3_adaptnet.weights.storage import BITS

KEYS = ("tasks", "seeds", "bits", "overrides", "evaluate", "resources", "minutes", "retries")
"""Keys of a sweep's file; keys that begin with a dot hold building blocks, as in the zoo."""
TASK_KEYS = ("id", "name", "seeds", "bits")
"""Keys of a task that are no changes."""
FILES = ("run", "result")
"""Stems of the JSON files in a run's folder, which the card of a task's weights must not replace."""


@dataclass(frozen=True)
class Task:
    """One environment to train on.

    Attributes:
        name: of its weight files and, with override and seed, of its run folders.
        env_id: the environment.
        seeds: of its runs.
        bits: what a weight is stored in; see `weights.storage`.
        changes: settings of the run and keys of the zoo's entry that are not as usual.
    """

    name: str
    env_id: str
    seeds: tuple[int, ...]
    bits: int = BITS[0]
    changes: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Resources:
    """What one run takes of a machine.

    Attributes:
        cpus: processor cores; None for all of the machine that starts the sweep.
        gpus: graphics cards; with any, the run's device is "cuda".
        threads: of physics and networks; None for as many as cores.
    """

    cpus: float | None = None
    gpus: float = 0.0
    threads: int | None = None


@dataclass(frozen=True)
class Measurement:
    """How every run is measured at its end.

    Attributes:
        seconds: simulated seconds.
        seeds: of start states and goals; each gives figures of its own.
    """

    seconds: float
    seeds: tuple[int, ...] = (0,)


@dataclass(frozen=True)
class Sweep:
    """A sweep's file: tasks x overrides x seeds.

    Attributes:
        name: the file's, without its extension.
        tasks: what to train on.
        overrides: name -> changes, on top of a task's; one without name and changes where the file has none.
        measurement: how the results are measured; None for not at all.
        resources: what one run takes.
        minutes: between checkpoints.
        retries: how often a run whose process died is taken up again before it counts as failed.
    """

    name: str
    tasks: tuple[Task, ...]
    overrides: dict[str, dict[str, Any]]
    measurement: Measurement | None = None
    resources: Resources = Resources()
    minutes: float = 3.0
    retries: int = 3


def read_sweep(file_or_name: str | Path) -> Sweep:
    """Read a sweep's file, or a shipped one by its name.

    Raises:
        ValueError: if there is none, or it is not as it must be.
    """
    file = Path(file_or_name) if Path(file_or_name).is_file() else sweep_path(str(file_or_name))
    try:
        read = yaml.load(file.read_text(encoding="utf-8"), Loader=LOADER)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ValueError(f"{file} is not a YAML file: {' '.join(str(error).split())}") from error
    where = file.name
    entries = mapping(f"{where}: the file", read)
    entries = mapping(where, {key: value for key, value in entries.items() if not key.startswith(".")}, KEYS)
    tasks = entries.get("tasks")
    if not isinstance(tasks, list) or not tasks:
        raise ValueError(f"{where}: tasks is {tasks!r}, expected a list of environment ids")
    usual = seeds(f"{where}: seeds", entries.get("seeds", [0])), entries.get("bits", BITS[0])
    return Sweep(
        name=label(f"{where}: its name", file.stem),
        tasks=tuple(_task(where, task, *usual) for task in tasks),
        overrides=_overrides(where, entries.get("overrides")),
        measurement=_measurement(f"{where}: evaluate", entries.get("evaluate")),
        resources=_resources(f"{where}: resources", entries.get("resources") or {}),
        minutes=number(f"{where}: minutes", entries.get("minutes", Sweep.minutes)),
        retries=whole(f"{where}: retries", entries.get("retries", Sweep.retries)),
    )


def short_name(env_id: str) -> str:
    """What an environment is called where its whole id is too long: "AdaptNet/Humanoid-Stoop-v0" is "Stoop"."""
    name = env_id.rpartition(":")[2].rpartition("/")[2].removeprefix("Humanoid-")
    return re.sub(r"-v\d+$", "", name)


def _task(where: str, given: Any, usual_seeds: tuple[int, ...], usual_bits: Any) -> Task:
    values = {"id": given} if isinstance(given, str) else mapping(f"{where}: a task", given)
    if not isinstance(values.get("id"), str):
        raise ValueError(f"{where}: the task {given!r} names no environment; write id: AdaptNet/Humanoid-Stoop-v0")
    env_id = values["id"]
    usual = short_name(env_id)
    name = label(f"{where}: the name of {env_id}", values.get("name", f"Humanoid{usual}" if _taken(usual) else usual))
    if _taken(name):
        raise ValueError(f"{where}: the name of {env_id} is {name!r}, as a file of every run's folder is called")
    return Task(
        name=name,
        env_id=env_id,
        seeds=seeds(f"{where}: seeds of {env_id}", values["seeds"]) if "seeds" in values else usual_seeds,
        bits=one_of(f"{where}: bits of {env_id}", values.get("bits", usual_bits), BITS),
        changes={key: value for key, value in values.items() if key not in TASK_KEYS},
    )


def _taken(name: str) -> bool:
    """Whether the card of weights of this name would lie on another file of a run, also where case does not count."""
    return name.casefold() in FILES


def _overrides(where: str, given: Any) -> dict[str, dict[str, Any]]:
    if given is None:
        return {"": {}}
    found = mapping(f"{where}: overrides", given)
    return {label(f"{where}: an override", name): mapping(f"{where}: {name}", found[name] or {}) for name in found}


def _measurement(where: str, given: Any) -> Measurement | None:
    if given is None:
        return None
    values = mapping(where, given, ("seconds", "seeds"))
    measured = seeds(f"{where}: seeds", values.get("seeds", [0]))
    return Measurement(number(f"{where}: seconds", values.get("seconds"), least=1.0), measured)


def _resources(where: str, given: Any) -> Resources:
    values: Mapping[str, Any] = mapping(where, given, ("cpus", "gpus", "threads"))
    return Resources(
        cpus=number(f"{where}: cpus", values["cpus"], least=0.01) if "cpus" in values else None,
        gpus=number(f"{where}: gpus", values.get("gpus", 0)),
        threads=whole(f"{where}: threads", values["threads"], least=1) if "threads" in values else None,
    )
