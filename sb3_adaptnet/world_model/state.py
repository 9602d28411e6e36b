"""The state of a character in generalised coordinates: its skeleton cannot come apart."""

from collections.abc import Callable
from typing import NamedTuple

import torch

from sb3_adaptnet.world_model.rotations import rotate


class State(NamedTuple):
    """States of B characters, components first.

    Attributes:
        position: (3, B) of the root [m], world.
        orientation: (4, B) unit quaternion (w, x, y, z) of the root, world.
        velocity: (3, B) of the root [m/s], world.
        spin: (3, B) angular velocity of the root [rad/s], along the world's axes (MuJoCo's is along the root's).
        angles: (J, B) of the joints [rad].
        rates: (J, B) of the joints [rad/s].
    """

    position: torch.Tensor
    orientation: torch.Tensor
    velocity: torch.Tensor
    spin: torch.Tensor
    angles: torch.Tensor
    rates: torch.Tensor

    @classmethod
    def from_mujoco(cls, qpos: torch.Tensor, qvel: torch.Tensor) -> "State":
        """States from MuJoCo's `qpos` (B, 7 + J) and `qvel` (B, 6 + J)."""
        positions, velocities = qpos.t().contiguous(), qvel.t().contiguous()
        orientation = positions[3:7]
        return cls(
            position=positions[:3],
            orientation=orientation,
            velocity=velocities[:3],
            spin=rotate(orientation, velocities[3:6]),
            angles=positions[7:],
            rates=velocities[6:],
        )

    def map(self, function: Callable[[torch.Tensor], torch.Tensor]) -> "State":
        """The state with `function` applied to each of its parts."""
        return State(*(function(part) for part in self))

    def to(self, device: torch.device) -> "State":
        """The state on a device."""
        return self.map(lambda part: part.to(device))
