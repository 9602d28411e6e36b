"""One control step of a state: what changed over it, and how a change carries it on. Each undoes the other.

A *change* is (B, 12 + 2 J), along the axes of the heading frame before the step where it is a vector:

    0:3    change of the root's velocity [m/s]
    3:6    change of the root's angular velocity [rad/s]
    6:9    mean velocity of the root over the step, minus its velocity before the step [m/s]
    9:12   the same of the angular velocity [rad/s]
    12:    mean rates of the joints over the step, minus their rates before the step [rad/s]
    12+J:  change of the joints' rates [rad/s]

A body that keeps its velocities has a change of zero: what is left to learn is the work of forces.
"""

import torch

from sb3_adaptnet.world_model.links import HeadingView
from sb3_adaptnet.world_model.rotations import (
    about_z,
    conjugate,
    from_rotation_vector,
    multiply,
    normalised,
    to_rotation_vector,
)
from sb3_adaptnet.world_model.state import State

CONTROL_DT = 1 / 30
"""Control step [s]; paper, sec. 7."""
ROOT_NUMBERS = 12
"""Numbers of a change that are the root's."""


def change_size(joints: int) -> int:
    """Numbers of a change of a character with so many joints."""
    return ROOT_NUMBERS + 2 * joints


def change_between(before: State, after: State, view: HeadingView) -> torch.Tensor:
    """The change (B, 12 + 2 J) that carries `before` to `after` in one control step; `view` is that of `before`."""
    mean_velocity = (after.position - before.position) / CONTROL_DT
    mean_spin = to_rotation_vector(multiply(after.orientation, conjugate(before.orientation))) / CONTROL_DT
    mean_rates = (after.angles - before.angles) / CONTROL_DT
    vectors = (
        after.velocity - before.velocity,
        after.spin - before.spin,
        mean_velocity - before.velocity,
        mean_spin - before.spin,
    )
    local = [about_z(view.cos, -view.sin, vector) for vector in vectors]
    return torch.cat((*local, mean_rates - before.rates, after.rates - before.rates)).t().contiguous()


def integrate(state: State, change: torch.Tensor, view: HeadingView) -> State:
    """The state one control step later, by a change (B, 12 + 2 J); `view` is that of `state`."""
    joints = len(state.angles)
    root, mean_rates, rates = change.t().split((ROOT_NUMBERS, joints, joints))
    vectors = about_z(view.cos, view.sin, root.view(4, 3, -1).transpose(0, 1))
    velocity, spin, mean_velocity, mean_spin = vectors.unbind(1)
    turn = from_rotation_vector(CONTROL_DT * (state.spin + mean_spin))
    return State(
        position=state.position + CONTROL_DT * (state.velocity + mean_velocity),
        orientation=normalised(multiply(turn, state.orientation)),
        velocity=state.velocity + velocity,
        spin=state.spin + spin,
        angles=state.angles + CONTROL_DT * (state.rates + mean_rates),
        rates=state.rates + rates,
    )
