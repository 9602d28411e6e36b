"""Fitting the world model of a base from nothing: data, stages, errors, file."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from adapt_envs import AdaptVectorEnv, make_vector
from adapt_envs.progress import Progress
from sb3_adaptnet.modules.layers.precision import use_precision
from sb3_adaptnet.policies.loading import load_policy
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.fitting.collecting import Act, collect
from sb3_adaptnet.world_model.fitting.error_table import ErrorTable, error_table
from sb3_adaptnet.world_model.fitting.fit import STAGES, fit, scaled, set_statistics
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.transitions import Transitions
from sb3_adaptnet.world_model.world_file import save_world

SLOWER, FASTER = 0.35, 1.2
"""Preferred speeds of the data, in the environment's lowest and highest: styles are slow."""
EPISODE_STEPS = 120
"""Control steps of an episode at most; disturbances are sampled for each."""


@dataclass(frozen=True)
class FitPlan:
    """What to fit.

    Attributes:
        env_id: environment that data come from.
        policies: names or files of the policies that act, each in an equal share of the worlds.
        worlds: their number.
        steps: control steps of each.
        effort: factor on the number of updates.
        seed: of everything.
        threads: of physics and networks; None for all cores.
        sizes: of the network.
        held_out: every so many worlds are kept for judging.
        env_kwargs: further arguments of the environment, such as the motion that the policies learned.
    """

    env_id: str
    policies: tuple[str, ...]
    worlds: int = 512
    steps: int = 1700
    effort: float = 1.0
    seed: int = 0
    threads: int | None = None
    sizes: Sizes = Sizes()
    held_out: int = 20
    env_kwargs: Mapping[str, Any] = field(default_factory=dict)


def record_transitions(plan: FitPlan, progress: Progress = iter) -> tuple[Transitions, Character]:
    """Transitions of the plan's policies, disturbed, at slow and fast speeds; and whose they are.

    Raises:
        ValueError: if an environment or a policy does not exist or does not fit, or there is a heightmap, which world
            models do not know.
    """
    own = {"max_episode_steps": EPISODE_STEPS, "stagger": True, "num_threads": plan.threads}
    env = make_vector(plan.env_id, plan.worlds, **{**plan.env_kwargs, **own})
    if env.worlds.spec.heightmap:
        raise ValueError(f"{plan.env_id} has uneven ground, which world models do not know; name another environment")
    low, high = env.worlds.goals.speed_range
    env.worlds.goals.speed_range = SLOWER * low, FASTER * high
    data = collect(env, shared_worlds(plan.policies, env), plan.steps, np.random.default_rng(plan.seed), progress)
    character = Character.of(env.model)
    env.close()
    return data, character


def shared_worlds(policies: Sequence[str], env: AdaptVectorEnv) -> Act:
    """One policy out of several: each acts in its share of the worlds, by its mean action."""
    acting = [load_policy(name, env) for name in policies]
    shares = np.array_split(np.arange(env.num_envs), len(acting))

    def act(observations: Any) -> NDArray[np.floating]:
        pairs = zip(acting, shares, strict=True)
        return np.concatenate([policy.predict(observations[rows], deterministic=True)[0] for policy, rows in pairs])

    return act


def fit_world(
    plan: FitPlan,
    output: str | Path,
    progress: Callable[[str], Progress] = lambda _: iter,
    report: Callable[[str], Any] = lambda _: None,
) -> Path:
    """Collect data, fit a model to it and write its file, with what it was made of and how far it errs.

    Args:
        plan: what to fit.
        output: the file.
        progress: gives each part of the work, by its name, something that shows how far it is.
        report: is told each stage's errors.

    Returns:
        The file.
    """
    begun = time.monotonic()
    if plan.threads is not None:
        torch.set_num_threads(plan.threads)
    torch.manual_seed(plan.seed)
    data, character = record_transitions(plan, progress("walking"))
    fitted, judged = data.split(plan.held_out)
    model = WorldModel(character, plan.sizes)
    model.dynamics.precision = use_precision("auto")
    errors = fit_stages(model, fitted, judged, plan, progress, report)
    training = {"policies": list(plan.policies), "transitions": int(data.actions.shape[0] * data.num_worlds),
                "seed": plan.seed, "seconds": round(time.monotonic() - begun)}  # fmt: skip
    return save_world(model, output, environment=plan.env_id, training=training, errors=errors.to_dict())


def fit_stages(
    model: WorldModel,
    fitted: Transitions,
    judged: Transitions,
    plan: FitPlan,
    progress: Callable[[str], Progress],
    report: Callable[[str], Any],
) -> ErrorTable:
    """Fit through all stages; returns the last errors on the transitions to judge by."""
    rng = np.random.default_rng(plan.seed)
    set_statistics(model, fitted, rng)
    optimizer = torch.optim.Adam(model.parameters())
    for stage in scaled(STAGES, plan.effort):
        losses = fit(model, fitted, stage, optimizer, rng)
        for _ in progress(f"fitting {stage.steps} steps")(range(stage.updates)):
            next(losses)
        errors = error_table(model, judged)
        report(f"after {stage.updates:,} updates of {stage.steps} steps\n{errors}")
    return errors
