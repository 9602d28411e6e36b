"""How far a character is from its reference motion, in its own heading frame."""

from dataclasses import dataclass

import torch

from sb3_adaptnet.algorithms.tracking.soles import corner_motion
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.links import ORIENTATION, POSITION, SPIN, VELOCITY
from sb3_adaptnet.world_model.pseudo_huber import pseudo_huber
from sb3_adaptnet.world_model.state import State

POSITION_SCALE, ORIENTATION_SCALE, VELOCITY_SCALE, SPIN_SCALE, ANGLE_SCALE = 0.1, 0.4, 1.0, 4.0, 0.25
"""Errors [m, rad, m/s, rad/s, rad] from which on the loss grows straight."""

SLIP_SCALE, CLEARANCE_SCALE = 0.1, 0.03
"""Speed [m/s] and error of the height [m] of a sole from which on their losses grow straight."""


@dataclass(frozen=True)
class TrackingWeights:
    """How much the parts of the tracking loss count.

    Attributes:
        position, orientation, velocity, spin: of the links.
        angle: of the joints.
        footing: of speeds over the ground where the reference's soles stand.
        clearance: of the heights of the soles' corners: centimetres decide what is flight, and count little elsewhere.
    """

    position: float = 1.0
    orientation: float = 0.5
    velocity: float = 0.3
    spin: float = 0.1
    angle: float = 1.0
    footing: float = 0.0
    clearance: float = 0.0


def tracking_loss(
    state: State,
    links: torch.Tensor,
    motion: TrackedMotion,
    phases: torch.Tensor,
    turn_rates: torch.Tensor,
    weights: TrackingWeights,
) -> torch.Tensor:
    """Loss (B,) of poses and velocities.

    Args:
        state: the characters' states.
        links: their link array (13, L, B), heading frame.
        motion: the reference.
        phases: (B,) where they should be in it.
        turn_rates: (B,) turn rate [rad/s] of the guides, with which the reference turns.
        weights: of the parts.
    """
    wanted = motion.links[:, :, phases]
    error = links - turned(wanted, turn_rates)
    by_link = motion.link_weights
    overlap = (links[ORIENTATION] * wanted[ORIENTATION]).sum(0)
    squares = {
        "position": (by_link * pseudo_huber(error[POSITION].square().sum(0), POSITION_SCALE)).mean(0),
        "orientation": pseudo_huber(4 * (1 - overlap.square()).clamp_min(0), ORIENTATION_SCALE).mean(0),
        "velocity": (by_link * pseudo_huber(error[VELOCITY].square().sum(0), VELOCITY_SCALE)).mean(0),
        "spin": pseudo_huber(error[SPIN].square().sum(0), SPIN_SCALE).mean(0),
        "angle": _angle_loss(state, motion, phases),
    }
    if weights.footing > 0 or weights.clearance > 0:
        squares |= _sole_losses(links, motion, phases)
    total = torch.zeros_like(turn_rates)
    for name, value in squares.items():
        total = total + getattr(weights, name) * value
    return total


def _angle_loss(state: State, motion: TrackedMotion, phases: torch.Tensor) -> torch.Tensor:
    square = (state.angles - motion.angles[:, phases]).square()
    return (motion.joint_weights * pseudo_huber(square, ANGLE_SCALE)).mean(0)


def _sole_losses(links: torch.Tensor, motion: TrackedMotion, phases: torch.Tensor) -> dict[str, torch.Tensor]:
    heights, square = corner_motion(links, motion.corners)
    error = heights - motion.clearance[:, phases]
    return {
        "footing": (motion.standing[:, phases] * pseudo_huber(square, SLIP_SCALE)).mean(0),
        "clearance": pseudo_huber(error.square(), CLEARANCE_SCALE).mean(0),
    }


def turned(links: torch.Tensor, turn_rates: torch.Tensor) -> torch.Tensor:
    """Link arrays (13, L, B), heading frame, of characters that turn about their roots' vertical at rates (B,) [rad/s].

    Velocities gain rate x position, angular velocities the rate itself.
    """
    gain = torch.zeros_like(links)
    gain[1], gain[4], gain[8] = -turn_rates * links[3], turn_rates * links[0], turn_rates
    return links + gain
