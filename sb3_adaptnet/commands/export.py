"""`adaptnet export`: a run's checkpoint to a weight file with a card."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

from stable_baselines3.common.utils import ConstantSchedule

from adapt_envs import AdaptVectorEnv, TaskSpec
from adapt_envs.commands.output import check_output
from adapt_envs.motion.library import load_clip, ships
from sb3_adaptnet.evaluation.card import TRAINING_MEANS
from sb3_adaptnet.runs.curve import panels
from sb3_adaptnet.runs.experiment import Experiment
from sb3_adaptnet.runs.history import Row, read_rows
from sb3_adaptnet.runs.run_folder import RunFolder
from sb3_adaptnet.runs.training import make_worlds
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.weights.checkpoint import BASE, save_adaptation, save_base
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX

CLIP_SUFFIX = ".motion.npz"
"""Comes after the weights' name: their reference clip, if it is none of those that ship."""
LAST_ROLLOUTS = 10
"""Rollouts at the end of training that the card's means are taken over."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `export`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "export", help="write a run's policy as a base or an adaptation (safetensors and a JSON card)"
    )
    parser.add_argument("run_dir", metavar="RUN", help="folder of the run")
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help="where to, as in mine.safetensors")
    parser.add_argument("--half", action="store_true", help="store the weights in half precision, in half the room")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Export and say where the file is."""
    print(export(options.run_dir, options.output, options.half))
    return 0


def export(run_dir: str | Path, output: str | Path, half: bool = False) -> Path:
    """Write the policy of a run's checkpoint: a base if it was trained whole, else an adaptation.

    Args:
        run_dir: the run's folder.
        output: where to.
        half: store the weights in half precision.

    Returns:
        The file; its card lies beside it, and a copy of the clip if that is none of those that ship.

    Raises:
        ValueError: if there is no run, no checkpoint, or the output's folder does not exist.
    """
    check_output(output)
    folder = RunFolder.open(run_dir)
    state = folder.load()
    entry = folder.experiment
    worlds = make_worlds(replace(folder.settings, n_envs=1), entry)
    policy: Any = entry.policy(
        worlds.observation_space, worlds.action_space, ConstantSchedule(0.0), **entry.arguments["policy_kwargs"]
    )
    policy.load_state_dict(state["policy"])
    spec = task_of(worlds)
    motion = None if spec is None else spec.motion
    card = card_of(folder, entry, int(state["samples"]), spec) | clip_of(motion, Path(output))
    worlds.close()
    save = save_base if policy.export()[0] == BASE else save_adaptation
    file = save(policy, output, half, **card)
    if motion is not None and not ships(motion):
        load_clip(motion).save(file.with_name(card["motion"]))
    return file


def task_of(worlds: AdaptVecEnv) -> TaskSpec | None:
    """The task's row with its overrides, where the worlds are this project's."""
    vector = worlds.vector_env.unwrapped
    return vector.worlds.spec if isinstance(vector, AdaptVectorEnv) else None


def clip_of(motion: str | None, output: Path) -> dict[str, Any]:
    """Name and hash of the reference clip; one that does not ship is named by its copy beside the weights."""
    if motion is None:
        return {}
    beside = f"{output.name.removesuffix(WEIGHT_SUFFIX)}{CLIP_SUFFIX}"
    return {"motion": motion if ships(motion) else beside, "clip_hash": load_clip(motion).digest}


def card_of(folder: RunFolder, entry: Experiment, samples: int, spec: TaskSpec | None) -> dict[str, Any]:
    """Entries of the card: where the weights come from and what training reported at its end."""
    settings = folder.settings
    policy_kwargs = dict(entry.arguments["policy_kwargs"])
    if policy_kwargs.get("base") is not None:  # its name: where the file lay means nothing elsewhere
        policy_kwargs["base"] = Path(policy_kwargs["base"]).name.removesuffix(WEIGHT_SUFFIX)
    training = {
        "samples": samples,
        "seed": settings.seed,
        "worlds": settings.n_envs or entry.n_envs,
        "policy": public_path(entry.policy),
        entry.algorithm: {**entry.arguments, "policy_kwargs": policy_kwargs},
        "callbacks": [{cls.__name__: kwargs} for cls, kwargs in entry.callbacks],
        TRAINING_MEANS: means_of(read_rows(folder.progress, samples)[-LAST_ROLLOUTS:]),
    }
    if spec is not None and (spec.terrain is not None or spec.obstacles is not None):
        training["terrain_seed"] = spec.terrain_seed
    return {"environment": settings.env_id, "training": training}


def means_of(rows: Sequence[Row]) -> dict[str, float]:
    """Means of what every one of the rows has, and over how many `rollouts` they are; none of no rows."""
    names = [name for name in panels({"": rows}) if rows and all(name in row for row in rows)]
    means = {name: round(sum(row[name] for row in rows) / len(rows), 4) for name in names}
    return {"rollouts": len(rows), **means} if means else {}


def public_path(cls: type) -> str:
    """Dotted name of a class: by its package alone where that exports it, as YAML files name it."""
    package = cls.__module__.partition(".")[0]
    public = getattr(import_module(package), cls.__qualname__, None) is cls
    return f"{package if public else cls.__module__}.{cls.__qualname__}"
