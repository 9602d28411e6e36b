"""`adaptnet world-model`: fit the world model of a base, and see how far it errs."""

import argparse
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from adapt_envs.commands.numbers import positive, seed_of
from adapt_envs.commands.output import check_output
from sb3_adaptnet.commands.policy_options import ProgressBar
from sb3_adaptnet.hub import is_address
from sb3_adaptnet.runs.error_plot import draw_errors
from sb3_adaptnet.runs.world_fit import FitPlan, fit_world, record_transitions
from sb3_adaptnet.weights.card import environment_of, trained_in
from sb3_adaptnet.weights.weight_file import check_card_place
from sb3_adaptnet.world_model.fitting.error_table import HORIZONS, coasting, error_table
from sb3_adaptnet.world_model.world_file import read_world

EVAL_WORLDS, EVAL_STEPS = 64, 400
"""Worlds and control steps that a model is judged by."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommands `world-model fit` and `world-model eval`."""
    parser = subparsers.add_parser("world-model", help="fit the world model of a base, or measure its errors")
    actions = parser.add_subparsers(dest="action", required=True, metavar="WHAT")
    _add_fit(actions)
    _add_eval(actions)


def _add_fit(actions: Any) -> None:
    parser: argparse.ArgumentParser = actions.add_parser("fit", help="collect data with a base, fit a model to it")
    parser.add_argument("base", metavar="BASE", help="name or file of the policy that acts, as in walk")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="default BASE.world.safetensors")
    parser.add_argument("--env", metavar="ID", help="environment; default: the one it was trained in")
    words = "further policies that act, as in walk-stoop,walk-penguin; none is needed"
    parser.add_argument("--policies", default="", metavar="A,B", help=words)
    parser.add_argument("--worlds", type=positive, default=512, help="worlds that data come from (default 512)")
    parser.add_argument("--steps", type=positive, default=1700, help="control steps of each (default 1700)")
    parser.add_argument("--effort", type=effort_of, default=1.0, help="factor on the number of updates (default 1)")
    _add_common(parser)
    parser.set_defaults(run=run_fit)


def _add_eval(actions: Any) -> None:
    parser: argparse.ArgumentParser = actions.add_parser("eval", help="open-loop errors of a model on fresh rollouts")
    parser.add_argument("file", metavar="FILE", type=Path, help="file of the model")
    parser.add_argument("--policy", metavar="NAME|FILE", help="policy that acts; default: those that it was fitted to")
    parser.add_argument("--env", metavar="ID", help="environment; default: the one it was fitted in")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.png", help="picture of the errors over the horizon")
    _add_common(parser)
    parser.set_defaults(run=run_eval)


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seed", type=seed_of, default=0, help="default 0")
    parser.add_argument("--threads", type=positive, help="threads of physics and networks; default: all cores")


def run_fit(options: argparse.Namespace) -> int:
    """Fit, telling the errors of each stage, and say where the file is."""
    if options.worlds < FitPlan.held_out:
        raise ValueError(f"{options.worlds} worlds are too few to keep some for judging: at least {FitPlan.held_out}")
    output = options.output or Path(f"{Path(options.base).stem}.world.safetensors")
    check_output(output)
    check_card_place(output)
    policies = (options.base, *(name for name in options.policies.split(",") if name))
    environment, motion = (options.env, None) if options.env is not None else trained_in(options.base)
    plan = FitPlan(
        env_id=environment,
        env_kwargs={} if motion is None else {"motion": motion},
        policies=policies,
        worlds=options.worlds,
        steps=options.steps,
        effort=options.effort,
        seed=options.seed,
        threads=options.threads,
    )
    file = fit_world(plan, output, ProgressBar, lambda words: print(words, flush=True))
    print(f"wrote {file}; measure it with: adaptnet world-model eval {file}")
    return 0


def run_eval(options: argparse.Namespace) -> int:
    """Print the errors on rollouts that the model has not seen, and draw them if asked to."""
    if options.output is not None:
        check_output(options.output, ".png")
    model, card = read_world(options.file)
    plan = FitPlan(
        env_id=options.env or environment_of(card, str(options.file)),
        policies=(options.policy,) if options.policy else policies_of(card, str(options.file)),
        worlds=EVAL_WORLDS,
        steps=EVAL_STEPS,
        seed=options.seed + 1,  # the data of a fit have its own seed
        threads=options.threads,
    )
    data, character = record_transitions(plan, ProgressBar("walking"))
    if character.joints != model.character.joints:
        raise ValueError(f"{options.file} models a character with other joints than that of {plan.env_id}")
    every = tuple(range(1, HORIZONS[-1] + 1))
    errors = error_table(model, data, plan.seed, horizons=every)
    print(errors.at(HORIZONS))
    if options.output is not None:
        reference = error_table(coasting(model), data, plan.seed, horizons=every)
        draw_errors(errors, reference, options.output, f"{options.file.name} in {plan.env_id}, seed {options.seed}")
        print(f"wrote {options.output}")
    return 0


def policies_of(card: Mapping[str, Any], file: str) -> tuple[str, ...]:
    """Policies that the card of a world model names.

    Raises:
        ValueError: if it names none, or what would be fetched because a file says so.
    """
    training = card.get("training")
    names = training.get("policies") if isinstance(training, dict) else None
    known = names if isinstance(names, list) else []
    if not known or not all(isinstance(name, str) and not is_address(name) for name in known):
        raise ValueError(f"{file!r} was fitted to {names!r}; name a policy with --policy")
    return tuple(known)


def effort_of(text: str) -> float:
    """Parse a positive factor."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive factor")
    return value
