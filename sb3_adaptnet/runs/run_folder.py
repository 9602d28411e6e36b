"""The folder of one training run: what was asked for, its configuration, checkpoint, progress, curve."""

import json
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import torch
import yaml

from adapt_envs.motion.library import load_clip, ships
from sb3_adaptnet.runs.experiment import Experiment, conf_path, experiment, read_entry
from sb3_adaptnet.weights.atomic_file import write_atomically

RUNS = Path("runs")
"""Folder of the runs that were given no path, in the working directory."""
DESCRIPTION = "run.json"
"""File in a run's folder: its settings."""
MOTION = "motion.npz"
"""File in a run's folder: the clip as it was trained on, if it is none of those that ship."""


@dataclass(frozen=True)
class RunSettings:
    """What a run was asked to do; enough to build the same model again.

    Attributes:
        env_id: environment.
        samples: control steps over all worlds to reach.
        seed: seed of networks, worlds and orders.
        conf_file: YAML file or shipped name; None for the algorithm's.
        base: base to adapt, name or file; None for the entry's.
        motion: clip or file for environments that take `motion=`.
        n_envs: worlds; None for the entry's.
        device: "cpu" or "cuda".
        threads: threads of physics and networks; None for all cores.
        algo: the algorithm, "ppo" or "svg".
        world_model: file of SVG's world model; None for the entry's.
        start: adaptation to go on from, name or file; None for the entry's, if it has one.
    """

    env_id: str
    samples: int
    seed: int = 0
    conf_file: str | None = None
    base: str | None = None
    motion: str | None = None
    n_envs: int | None = None
    device: str = "cpu"
    threads: int | None = None
    algo: str = "ppo"
    world_model: str | None = None
    start: str | None = None


class RunFolder:
    """Paths and files of a run.

    Attributes:
        path: the folder.
        settings: what was asked for.
        motion: a copy of the clip, if it does not ship: the folder may be moved.
        config: the zoo's entry as it was when the run began; a resumed run reads it again.
    """

    def __init__(self, path: Path, settings: RunSettings) -> None:
        """Name a folder; nothing is written."""
        self.path, self.settings = path, settings
        self.config = path / "config.yml"
        self.motion = path / MOTION
        self.checkpoint = path / "checkpoint.pt"
        self.progress = path / "progress.csv"
        self.curve = path / "curve.png"

    @classmethod
    def new(cls, settings: RunSettings, path: str | Path) -> "RunFolder":
        """Create the folder, write `run.json` and `config.yml`.

        Raises:
            ValueError: if the path holds a run already, or there is no entry for what it shall train on.
        """
        folder = cls(Path(path), settings)
        config = folder.check_free()
        folder.path.mkdir(parents=True, exist_ok=True)
        if settings.motion is not None and not ships(settings.motion):
            load_clip(settings.motion).save(folder.motion)
            settings = replace(settings, motion=str(folder.motion))
        folder.write_settings(settings)
        text = yaml.safe_dump(config, sort_keys=False)
        write_atomically(folder.config, lambda stream: stream.write(text.encode()))
        return folder

    def check_free(self) -> dict[str, Any]:
        """What a new run's `config.yml` says: the entry of the zoo by its id; nothing is written.

        Raises:
            ValueError: if the path holds a run already, or something else, or there is no entry.
        """
        settings = self.settings
        config = {settings.env_id: read_entry(conf_path(settings.conf_file or settings.algo), settings.env_id)}
        if self.has_begun(self.path):
            raise ValueError(f"{self.path} holds a run already; continue it with --resume {self.path}")
        self._refuse_foreign(config)
        return config

    def _refuse_foreign(self, config: dict[str, Any]) -> None:
        """Refuse to write over what no run of ours left; a `config.yml` that says just this may be there."""
        if (self.path / DESCRIPTION).exists():
            return
        there = [file for file in (self.checkpoint, self.progress, self.curve) if file.is_file()]
        if self.config.is_file():
            try:
                same = yaml.safe_load(self.config.read_text(encoding="utf-8")) == config
            except (yaml.YAMLError, UnicodeDecodeError):
                same = False
            there += [] if same else [self.config]
        if there:
            names = ", ".join(file.name for file in there)
            raise ValueError(f"{self.path} holds {names} but no {DESCRIPTION} of a run; choose another folder")

    @staticmethod
    def has_begun(path: Path) -> bool:
        """Whether a folder holds a run that can be resumed: one killed before its first checkpoint may begin again."""
        return (path / DESCRIPTION).exists() and (path / "checkpoint.pt").exists()

    @classmethod
    def open(cls, path: str | Path) -> "RunFolder":
        """Open a run by its folder, or by its name under `runs/`.

        Raises:
            ValueError: if there is no run, or its description is damaged.
        """
        folder = Path(path) if (Path(path) / DESCRIPTION).is_file() else RUNS / path
        file = folder / DESCRIPTION
        if not file.is_file():
            raise ValueError(f"no training run at {path}: it has no {DESCRIPTION}")
        try:
            values = {"algo": "ppo", "world_model": None, "start": None, **json.loads(file.read_text(encoding="utf-8"))}
            settings = RunSettings(**{f.name: values[f.name] for f in fields(RunSettings)})
            if settings.motion == MOTION:
                settings = replace(settings, motion=str(folder / MOTION))
            return cls(folder, settings)
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f"{file} is damaged: {error}") from error

    @property
    def experiment(self) -> Experiment:
        """What the run trains with: its own `config.yml`, whatever became of the file that it was copied from.

        Raises:
            ValueError: if that was removed or damaged.
        """
        return experiment(
            self.settings.env_id, self.settings.base, self.config, self.settings.algo, self.settings.start
        )

    def write_settings(self, settings: RunSettings) -> None:
        """Write `run.json`; a clip in the folder is named without the folder, which may move."""
        self.settings = settings
        motion = MOTION if settings.motion == str(self.motion) else settings.motion
        text = json.dumps(asdict(replace(settings, motion=motion)), indent=2) + "\n"
        write_atomically(self.path / DESCRIPTION, lambda stream: stream.write(text.encode()))

    def save(self, state: dict[str, Any]) -> None:
        """Write the checkpoint; a kill at any moment leaves the old or the new one whole."""
        write_atomically(self.checkpoint, lambda stream: torch.save(state, stream))

    def remove_parts(self) -> None:
        """Remove what kills left of checkpoints that were being written; the folder must be held."""
        for part in self.path.glob(f".{self.checkpoint.name}.*.part"):
            part.unlink(missing_ok=True)

    def load(self) -> dict[str, Any]:
        """Read the checkpoint, tensors and plain values alone (no code runs), into main memory.

        Raises:
            ValueError: if there is none, or it cannot be read.
        """
        if not self.checkpoint.is_file():
            raise ValueError(f"{self.path} has no checkpoint yet")
        try:
            state = torch.load(self.checkpoint, map_location="cpu", weights_only=True)
            int(state["samples"]), state["policy"]
            return state
        except Exception as error:  # torch raises many kinds for a cut or foreign file
            raise ValueError(f"{self.checkpoint} is not a checkpoint of this program, or is cut short") from error


def next_path(env_id: str) -> Path:
    """Next free folder `runs/NAME_N`; the slash and colon of an id become dashes."""
    name, number = env_id.replace("/", "-").replace(":", "-"), 1
    while (RUNS / f"{name}_{number}").exists():
        number += 1
    return RUNS / f"{name}_{number}"
