"""The world model that a base from nothing learned by, measured, as the file that lies beside the base."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from adapt_envs.progress import Progress
from sb3_adaptnet.algorithms.model_based import NEW
from sb3_adaptnet.runs.run_folder import RunFolder
from sb3_adaptnet.runs.world_fit import FitPlan, record_transitions
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX
from sb3_adaptnet.world_model.fitting.error_table import error_table
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.world_file import beside_base, save_world

WORLDS, STEPS = 64, 400
"""Worlds and control steps, recorded with disturbances, that the model is judged by."""


def has_new_world(folder: RunFolder) -> bool:
    """Whether a run learned its own world model from nothing."""
    return (folder.settings.world_model or folder.experiment.arguments.get("world_model")) == NEW


def export_world(folder: RunFolder, state: Mapping[str, Any], base: Path, progress: Progress = iter) -> Path:
    """Write the world model of a run's checkpoint beside the base that was exported from it.

    Args:
        folder: the run.
        state: its checkpoint.
        base: file of its policy, who walks for the errors on the card.
        progress: shows how far that is.

    Returns:
        The file.
    """
    settings, env_kwargs = folder.settings, dict(folder.experiment.env_kwargs)
    if settings.motion is not None:
        env_kwargs["motion"] = settings.motion
    plan = FitPlan(settings.env_id, (str(base),), WORLDS, STEPS, seed=settings.seed + 1, env_kwargs=env_kwargs)
    data, character = record_transitions(plan, progress)
    weights = state["world"]["model"]
    model = WorldModel(character, Sizes.of(weights))
    model.load_state_dict(weights)
    errors = error_table(model, data, plan.seed)
    name = base.name.removesuffix(WEIGHT_SUFFIX)
    training = {"policies": [name], "samples": int(state["samples"]), "seed": settings.seed}
    return save_world(model, beside_base(base), environment=plan.env_id, training=training, errors=errors.to_dict())
