"""A reference motion as tensors: what a character shall look like at every phase."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.footsteps import footsteps_per_second
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.links import from_observed, heading_view, to_observed

OBSERVED_FRAMES = 4
"""Frames of the policy's observation; paper, sec. 7."""
SERVO_LEAD = 0.1
"""How far ahead [s] a servo aims that follows a motion: about its time constant kd / kp."""
FOOT_WEIGHT, LEG_WEIGHT = 4.0, 2.0
"""How much the feet count among the links, and the legs' joints among the joints; a style lives in them."""
_SMOOTHING = 31
"""Frames (about a second) over which a motion that does not repeat has one direction of travel."""


@dataclass(frozen=True, eq=False)
class TrackedMotion:
    """A motion of P phases. The *travel frame* has its x axis along the direction of travel.

    Attributes:
        links: link array (13, L, P), heading frame.
        angles: (J, P) of the joints [rad].
        facing: (P,) heading of the root relative to the direction of travel [rad].
        velocity: (2, P) of the root on the ground [m/s], travel frame.
        frames: (P, 4 * L * 13) body part of the observation in each phase.
        aims: (P, J) actions whose servos would follow the motion.
        link_weights: (L, 1) how much each link counts, 1 on average.
        joint_weights: (J, 1) the same of the joints.
        positions: (P, L, 3) of the links [m], heading frame: for comparing on the CPU.
        cyclic: whether phase 0 follows the last one.
        mean_speed: of the root [m/s].
        footsteps: of both feet per second; infinite if none are found.
    """

    links: torch.Tensor
    angles: torch.Tensor
    facing: torch.Tensor
    velocity: torch.Tensor
    frames: torch.Tensor
    aims: torch.Tensor
    link_weights: torch.Tensor
    joint_weights: torch.Tensor
    positions: NDArray[np.float32]
    cyclic: bool
    mean_speed: float
    footsteps: float

    @classmethod
    def of(
        cls,
        character: Character,
        device: torch.device,
        *,
        qpos: NDArray[np.float64],
        qvel: NDArray[np.float64],
        history: NDArray[np.float32],
        cyclic: bool,
        mean_speed: float,
    ) -> "TrackedMotion":
        """Prepare a reference motion, one state every 1/30 s.

        Args:
            character: whose motion it is.
            device: where the tensors shall be.
            qpos: (P, 7 + J), MuJoCo's.
            qvel: (P, 6 + J), MuJoCo's.
            history: (P, F, L, 13) link states that end in these states, world frame.
            cyclic: whether the first state follows the last one.
            mean_speed: of the root [m/s].
        """
        frames = history[:, -OBSERVED_FRAMES:].reshape(len(qpos), -1, history.shape[-1])
        view = heading_view(from_observed(torch.as_tensor(frames)), len(character.links))
        links = view.latest(len(character.links))
        travel = _directions(qvel[:, :2], cyclic)
        along, heading = _turned(qvel[:, :2], -travel), np.arctan2(view.sin.numpy(), view.cos.numpy())
        aims = qpos[:, 7:] + SERVO_LEAD * qvel[:, 6:]

        def tensor(values: NDArray[np.floating]) -> torch.Tensor:
            return torch.as_tensor(values, dtype=torch.float32, device=device).contiguous()

        return cls(
            links=links.contiguous().to(device),
            angles=tensor(qpos[:, 7:].T),
            facing=tensor((heading - travel + np.pi) % (2 * np.pi) - np.pi),
            velocity=tensor(along.T),
            frames=to_observed(view.links).to(device),
            aims=tensor((aims - np.array(character.middles)) / np.array(character.widths)),
            link_weights=tensor(_link_weights(character))[:, None],
            joint_weights=tensor(_joint_weights(character))[:, None],
            positions=links[0:9:3].permute(2, 1, 0).contiguous().numpy(),
            cyclic=cyclic,
            mean_speed=mean_speed,
            footsteps=footsteps_per_second(links[6, _feet(character)].numpy(), cyclic),
        )

    def __len__(self) -> int:
        """P."""
        return len(self.facing)

    def wrapped(self, phases: NDArray[np.integer]) -> NDArray[np.integer]:
        """Phases beyond the ends: a cyclic motion goes on, any other holds its ends."""
        return phases % len(self) if self.cyclic else np.clip(phases, 0, len(self) - 1)


def _directions(velocity: NDArray[np.float64], cyclic: bool) -> NDArray[np.float64]:
    """(P,) direction of travel [rad] of root velocities (P, 2): one for a cycle, else that of the second around."""
    if cyclic:
        mean = np.broadcast_to(velocity.mean(axis=0), velocity.shape)
    else:
        kernel = np.ones(min(_SMOOTHING, len(velocity)))
        mean = np.stack([np.convolve(part, kernel, mode="same") for part in velocity.T], axis=1)
    return np.arctan2(mean[:, 1], mean[:, 0])


def _turned(vectors: NDArray[np.float64], angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors (P, 2) turned by angles (P,) [rad]."""
    (x, y), c, s = vectors.T, np.cos(angle), np.sin(angle)
    return np.stack([c * x - s * y, s * x + c * y], axis=1)


def _feet(character: Character) -> list[int]:
    return sorted({link for link, _ in character.corners})


def _link_weights(character: Character) -> NDArray[np.float64]:
    """Feet count `FOOT_WEIGHT` times, the links above them half as much more than the others."""
    weights = np.ones(len(character.links))
    for foot in _feet(character):
        weights[foot], weights[character.parents[foot]] = FOOT_WEIGHT, (1 + FOOT_WEIGHT) / 2
    return weights / weights.mean()


def _joint_weights(character: Character) -> NDArray[np.float64]:
    """Joints on the way from the root to a foot count `LEG_WEIGHT` times."""
    legs = set()
    for link in _feet(character):
        while link > 0:
            legs.add(link)
            link = character.parents[link]
    weights = np.array([LEG_WEIGHT if link in legs else 1.0 for link, _ in character.hinges])
    return weights / weights.mean()
