"""One run of a sweep: what it shall do, and its folder, from which alone anyone can tell how far it is."""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from sb3_adaptnet.runs.experiment import LOADER
from sb3_adaptnet.runs.lock import is_locked
from sb3_adaptnet.runs.run_folder import RunFolder, RunSettings
from sb3_adaptnet.sweeps.sweep_file import Measurement
from sb3_adaptnet.weights.atomic_file import write_atomically
from sb3_adaptnet.weights.storage import BITS
from sb3_adaptnet.weights.weight_file import read_weights

WAITING, RUNNING, STOPPED, FAILED, DONE = "waiting", "running", "stopped", "failed", "done"
"""States of a run: not begun; a process is at it; begun and left; left by an error; trained, exported and measured."""
LOCK_SECONDS = 120.0
"""How long a process waits for another one in the same folder, which may just be writing its last checkpoint."""
MAY_CHANGE = ("samples", "the entry's n_timesteps", "threads", "device")
"""What may be another number when a run is taken up again."""


@dataclass(frozen=True)
class Unit:
    """One run of a sweep.

    Attributes:
        name: of its folder.
        task: name of the task, and of the weight file.
        override: name of the override; empty for none.
        settings: what to train.
        entry: the zoo's entry with all changes.
        measurement: how the result is measured; None for not at all.
        minutes: between checkpoints.
        bits: what a weight of the result is stored in.
        after: name of the run whose weights this one starts from; empty for none.
    """

    name: str
    task: str
    override: str
    settings: RunSettings
    entry: dict[str, Any]
    measurement: Measurement | None = None
    minutes: float = 3.0
    bits: int = BITS[0]
    after: str = ""

    def fixed(self) -> dict[str, Any]:
        """What may not change once the run has begun, by names for people."""
        values = {**asdict(self.settings), **{f"the entry's {key}": value for key, value in self.entry.items()}}
        return {name: value for name, value in values.items() if name not in MAY_CHANGE} | {"the start": self.after}


class UnitFolder:
    """Files of one run of a sweep, beside those of `RunFolder`.

    Attributes:
        path: the folder.
        unit_file: what to do.
        config: the zoo's entry with all changes; the run reads it.
        log: what its processes printed.
        failure: why the last process failed; not there otherwise.
        result: what became of it; there when it is done.
    """

    def __init__(self, path: str | Path) -> None:
        """Name a folder; nothing is written."""
        self.path = Path(path)
        self.unit_file, self.config = self.path / "unit.yml", self.path / "config.yml"
        self.log, self.failure, self.result = (self.path / name for name in ("log.txt", "failure.txt", "result.json"))

    @property
    def begun(self) -> bool:
        """Whether there is a checkpoint to go on from."""
        return RunFolder.has_begun(self.path)

    def read(self) -> Unit:
        """Read what to do.

        Raises:
            ValueError: if the folder is none of a sweep's, or the file is damaged.
        """
        if not self.unit_file.is_file():
            raise ValueError(f"{self.path} is not a run of a sweep: it has no {self.unit_file.name}")
        try:
            values = yaml.load(self.unit_file.read_text(encoding="utf-8"), Loader=LOADER)
            settings, measured = RunSettings(**values.pop("settings")), values.pop("measurement")
            if measured is not None:
                measured = Measurement(measured["seconds"], tuple(measured["seeds"]))
            return Unit(**values, name=self.path.name, settings=settings, measurement=measured)
        except (yaml.YAMLError, UnicodeDecodeError, TypeError, AttributeError, KeyError) as error:
            raise ValueError(f"{self.unit_file} is damaged: {' '.join(str(error).split())}") from error

    def write(self, unit: Unit) -> None:
        """Write what to do."""
        self.path.mkdir(parents=True, exist_ok=True)
        measured = unit.measurement and {"seconds": unit.measurement.seconds, "seeds": list(unit.measurement.seeds)}
        values = {"task": unit.task, "override": unit.override, "settings": asdict(unit.settings),
                  "entry": unit.entry, "measurement": measured, "minutes": unit.minutes, "bits": unit.bits,
                  "after": unit.after}  # fmt: skip
        text = yaml.safe_dump(values, sort_keys=False)
        write_atomically(self.unit_file, lambda stream: stream.write(text.encode()))

    def write_config(self, unit: Unit) -> RunSettings:
        """Write the entry to train with; return the run's settings that name it, and where the run starts from.

        Raises:
            ValueError: if the run that it starts from is not done.
        """
        start = unit.settings.start
        if unit.after:
            if not UnitFolder(self.path.parent / unit.after).is_done():
                raise ValueError(f"it starts from {unit.after}, which is not done")
            start = str(self._weights_before(unit))
        text = yaml.safe_dump({unit.settings.env_id: unit.entry}, sort_keys=False)
        write_atomically(self.config, lambda stream: stream.write(text.encode()))
        return replace(unit.settings, conf_file=str(self.config), start=start)

    def _weights_before(self, unit: Unit) -> Path:
        """The weights that a done run left, from which this one starts."""
        before = UnitFolder(self.path.parent / unit.after)
        return before.path / before.read_result()["weights"]

    def is_stale(self) -> bool:
        """Whether it is done, and the run that it started from has other weights by now."""
        unit, result = self.read(), self.read_result()
        if not unit.after or "start_hash" not in result:
            return False
        before = UnitFolder(self.path.parent / unit.after)
        if not before.read_result():  # it is being done again
            return False
        weights = self._weights_before(unit)
        return weights.is_file() and read_weights(weights)[1]["hash"] != result["start_hash"]

    def write_result(self, unit: Unit, samples: int, weights: Path, figures: list[dict[str, Any]]) -> None:
        """Say that the run is done, with how many samples and which figures, one for each seed of the measurement."""
        measured = None if unit.measurement is None else asdict(unit.measurement)
        result = {"samples": samples, "weights": weights.name, "bits": unit.bits, "measurement": measured,
                  "figures": figures}  # fmt: skip
        if unit.after:
            result["start_hash"] = read_weights(self._weights_before(unit))[1]["hash"]
        text = json.dumps(result, indent=2) + "\n"
        write_atomically(self.result, lambda stream: stream.write(text.encode()))
        self.failure.unlink(missing_ok=True)

    def read_result(self) -> dict[str, Any]:
        """What `write_result` wrote; empty while there is nothing.

        Raises:
            ValueError: if the file is damaged.
        """
        try:
            result = json.loads(self.result.read_text(encoding="utf-8")) if self.result.is_file() else {}
        except ValueError as error:
            raise ValueError(f"{self.result} is damaged: {error}") from error
        if not isinstance(result, dict) or (result and not _is_result(result)):
            raise ValueError(f"{self.result} is damaged: it holds no figures of a run; remove it to make it again")
        return result

    def is_done(self) -> bool:
        """Whether everything that is asked for is there."""
        unit, result = self.read(), self.read_result()
        measured = None if unit.measurement is None else json.loads(json.dumps(asdict(unit.measurement)))
        enough = result.get("samples", -1) >= unit.settings.samples and result.get("bits", BITS[0]) == unit.bits
        return enough and (measured is None or result["measurement"] == measured)

    def state(self) -> str:
        """The run's state; one of the constants above."""
        if self.is_done():
            return DONE
        if is_locked(self.path):
            return RUNNING
        if self.failure.is_file():
            return FAILED
        return STOPPED if self.begun else WAITING


def _is_result(values: dict[str, Any]) -> bool:
    """Whether it has the form of what `write_result` wrote."""
    figures = values.get("figures")
    if not (isinstance(values.get("weights"), str) and "measurement" in values and isinstance(figures, list)):
        return False
    needed = ("goal_reward", "falls_per_minute", "visible")
    known = all(isinstance(one, dict) and all(name in one for name in needed) for one in figures)
    return known and all(isinstance(values.get(name, 0), int | float) for name in ("samples", "bits"))
