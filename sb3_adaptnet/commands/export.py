"""`adaptnet export`: a run's checkpoint to a weight file with a card; bases and adaptations to ONNX."""

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
from sb3_adaptnet.commands.policy_options import ProgressBar, shared_out, styles_of
from sb3_adaptnet.evaluation.card import TRAINING_MEANS
from sb3_adaptnet.exporting import Exported, save_onnx
from sb3_adaptnet.runs.curve import panels
from sb3_adaptnet.runs.experiment import Experiment
from sb3_adaptnet.runs.history import Row, read_rows
from sb3_adaptnet.runs.run_folder import RunFolder
from sb3_adaptnet.runs.training import make_worlds
from sb3_adaptnet.runs.world_export import export_world, has_new_world
from sb3_adaptnet.stacking import JoinedWorlds
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.weights.checkpoint import BASE, read_kind, save_adaptation, save_base
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX
from sb3_adaptnet.weights.storage import BITS
from sb3_adaptnet.weights.weight_file import check_card_place
from sb3_adaptnet.world_model.world_file import beside_base, has_world

ONNX_SUFFIX = ".onnx"
CLIP_SUFFIX = ".motion.npz"
"""Comes after the weights' name: their reference clip, if it is none of those that ship."""
LAST_ROLLOUTS = 10
"""Rollouts at the end of training that the card's means are taken over."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `export`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "export", help="write a run's policy as a weight file, or a base with adaptations as one ONNX graph"
    )
    words = "folder of a run; or, for ONNX, a base and any number of its adaptations, NAME or NAME=STRENGTH each"
    parser.add_argument("what", metavar="RUN|POLICY", nargs="+", help=words)
    words = "where to: mine.safetensors for a run, which gets a JSON card, too; mine.onnx for a base with adaptations"
    parser.add_argument("-o", "--output", metavar="FILE", required=True, help=words)
    words = "what a weight is stored in: 32, 16, in half the room, or 8, in a quarter, but not for ONNX; by default 32"
    parser.add_argument("--bits", type=int, choices=BITS, default=BITS[0], help=words)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Export and say where the file is."""
    if Path(options.output).suffix == ONNX_SUFFIX:
        print(export_onnx(options.what, options.output, options.bits))
        return 0
    if len(options.what) > 1:
        raise ValueError(f"only ONNX takes several policies; {options.output!r} does not end in .onnx")
    file = export(options.what[0], options.output, options.bits)
    print(file)
    if has_new_world(RunFolder.open(options.what[0])) and has_world(file):
        print(beside_base(file))
    return 0


def export_onnx(policies: Sequence[str], output: str | Path, bits: int = 32) -> Path:
    """Write a base and its adaptations as one ONNX graph.

    Args:
        policies: the base, then its adaptations: NAME, or NAME=STRENGTH for another default strength than an equal
            share of what the others leave of 1.
        output: where to.
        bits: what a weight is stored in, 32 or 16.

    Raises:
        ValueError: if one cannot be read or does not fit, the output's folder does not exist, or for 8 bits.
    """
    check_output(output)
    if bits not in (32, 16):
        raise ValueError(f"an ONNX graph stores its weights in 32 or 16 bits, not in {bits}")
    if Path(policies[0]).is_dir():
        raise ValueError(f"{policies[0]!r} is a folder; export a run to mine.safetensors first, then that file to ONNX")
    base = policies[0]
    if read_kind(base) != BASE:
        raise ValueError(f"{base!r} is an adaptation; name its base first, as in: adaptnet export walk walk-stoop")
    try:
        styles = styles_of(",".join(policies[1:]))
    except argparse.ArgumentTypeError as error:
        raise ValueError(str(error)) from None
    exported = Exported.read(base, list(styles))
    strengths = dict(zip(exported.adaptations, shared_out(styles).values(), strict=True))
    return save_onnx(exported, output, strengths, half=bits == 16)


def export(run_dir: str | Path, output: str | Path, bits: int = 32) -> Path:
    """Write the policy of a run's checkpoint: a base if it was trained whole, else an adaptation.

    Args:
        run_dir: the run's folder.
        output: where to.
        bits: what a weight is stored in, 32, 16 or 8.

    Returns:
        The file; its card lies beside it, a copy of the clip if that is none of those that ship, and the world model
        if the run made a base and began without one.

    Raises:
        ValueError: if there is no run, no checkpoint, or the output's folder does not exist.
    """
    check_output(output)
    check_card_place(output)
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
    is_base = policy.export()[0] == BASE
    file = (save_base if is_base else save_adaptation)(policy, output, bits, **card)
    if is_base and has_new_world(folder):
        export_world(folder, state, file, ProgressBar("measuring the world model"))
    if motion is not None and not ships(motion):
        load_clip(motion).save(file.with_name(card["motion"]))
    return file


def task_of(worlds: AdaptVecEnv | JoinedWorlds) -> TaskSpec | None:
    """The task's row with its overrides, where the worlds are this project's; of joined ones the first group's."""
    vector = (worlds.groups[0] if isinstance(worlds, JoinedWorlds) else worlds).vector_env.unwrapped
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
    for key in ("base", "start"):
        if policy_kwargs.get(key) is not None:  # its name: where the file lay means nothing elsewhere
            policy_kwargs[key] = _name(policy_kwargs[key])
    if policy_kwargs.get("companions"):
        policy_kwargs["companions"] = [_name(file) for file in policy_kwargs["companions"]]
    model = {} if settings.world_model is None else {"world_model": Path(settings.world_model).name}
    training = {
        "samples": samples,
        "seed": settings.seed,
        "worlds": settings.n_envs or entry.n_envs,
        "policy": public_path(entry.policy),
        entry.algorithm: {**entry.arguments, **model, "policy_kwargs": policy_kwargs},
        "callbacks": [{cls.__name__: kwargs} for cls, kwargs in entry.callbacks],
        TRAINING_MEANS: means_of(read_rows(folder.progress, samples)[-LAST_ROLLOUTS:]),
    }
    if entry.env_kwargs:
        training["env_kwargs"] = entry.env_kwargs
    if spec is not None and (spec.terrain is not None or spec.obstacles is not None):
        training["terrain_seed"] = spec.terrain_seed
    return {"environment": settings.env_id, "training": training}


def _name(file: str | Path) -> str:
    return Path(file).name.removesuffix(WEIGHT_SUFFIX)


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
