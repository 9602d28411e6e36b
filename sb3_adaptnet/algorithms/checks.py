"""What numbers and choices of SVG must be."""

from numbers import Integral
from typing import Any

from sb3_adaptnet.algorithms.rollouts.strengths import check_share
from sb3_adaptnet.algorithms.tracking.tracked_groups import references_of
from sb3_adaptnet.objectives.schedule import checked_decay, highest, times_of, value_at
from sb3_adaptnet.policies.space_contract import companions_in

NEW = "new"
"""In place of a world model's file: begin one from nothing."""


def check_settings(svg: Any) -> None:
    """Refuse settings of an `SVG` that cannot be, do not go together, or not with its policy and worlds.

    Raises:
        ValueError: naming one.
        MotionError: for gaits that the motion does not have.
    """
    check_positive(
        n_steps=svg.n_steps, window=svg.window, gradient_steps=svg.gradient_steps, recent_rollouts=svg.recent_rollouts
    )
    if svg.window > svg.n_steps:
        raise ValueError(f"window is {svg.window}, expected 1 to n_steps, which is {svg.n_steps}")
    if not (isinstance(svg.regression_updates, int) and svg.regression_updates >= 0):
        raise ValueError(f"regression_updates is {svg.regression_updates!r}, expected a whole number of at least 0")
    check_batch(svg.batch_size, None if svg.env is None else svg.n_envs)
    checked_decay("average_decay", svg.average_decay)
    check_flag("mirror", svg.mirror)
    _check_later_fits(svg)
    check_share(svg.policy_class, svg.episodes.partial_share)
    symmetry = svg.loss_weights.weights.get("symmetry", 0.0)
    if highest(symmetry) > 0 and not svg.mirror:
        raise ValueError(f"symmetry {symmetry!r} is of what is done in the mirror, so mirror must be True")
    if companions_in(svg.observation_space):
        _check_beside_companions(svg)
    if svg.env is not None:
        references_of(svg.env, svg.guiding.gaits)


def _check_later_fits(svg: Any) -> None:
    """What the critic reads is normalised by the model, which a fit changes."""
    last, weight = max(svg.model_fits.efforts), svg.cost_to_go.weight
    before = [samples for samples in times_of(weight) if samples <= last]
    if svg.world_model_is_new and last > 0 and any(value_at(weight, samples) > 0 for samples in (*before, last)):
        raise ValueError(f"the critic's weight is {weight!r}, expected 0 until the last fit of the model, at {last}")


def _check_beside_companions(svg: Any) -> None:
    """Not every style is symmetric, and what acts in part beside a whole one was never looked at."""
    must_be = {
        "mirror": (svg.mirror, False),
        "regression_updates": (svg.regression_updates, 0),
        "episodes.partial_share": (highest(svg.episodes.partial_share), 0),
    }
    for name, (value, wanted) in must_be.items():
        if value != wanted:
            raise ValueError(f"{name} is {value!r}, but beside companions it must be {wanted!r}")
    if svg.world_model_is_new:
        raise ValueError(f"world_model is {NEW!r}, but beside companions it must be one that is there")


def check_positive(**numbers: int) -> None:
    """Refuse numbers of things of which there must be one.

    Raises:
        ValueError: for one below 1 or no whole number, with its name.
    """
    for name, number in numbers.items():
        if not isinstance(number, Integral) or isinstance(number, bool) or number < 1:
            raise ValueError(f"{name} is {number!r}, expected a whole number of at least 1")


def check_batch(batch_size: int | None, worlds: int | None) -> None:
    """Refuse a batch of worlds that are not there.

    Raises:
        ValueError: for one below 1, or above the number of worlds where that is known.
    """
    number = isinstance(batch_size, Integral) and not isinstance(batch_size, bool)
    if batch_size is not None and not (number and 0 < batch_size <= (worlds or batch_size)):
        most = "the number of worlds" if worlds is None else f"{worlds}, the number of worlds"
        raise ValueError(f"batch_size is {batch_size!r}, expected 1 to {most}, or None for all")


def check_flag(name: str, value: bool) -> None:
    """Refuse what is neither True nor False: "no" would count as yes.

    Raises:
        ValueError: naming the value.
    """
    if not isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}, expected True or False")
