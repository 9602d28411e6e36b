"""A reference motion as tensors: what a character shall look like at every phase."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.footsteps import footsteps_per_second
from sb3_adaptnet.algorithms.tracking.gaits import Gaits
from sb3_adaptnet.algorithms.tracking.soles import corner_motion, corners_of, standing
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.links import LINK_NUMBERS, POSITION, VELOCITY, from_observed, heading_view, to_observed

OBSERVED_FRAMES = 4
"""Frames of the policy's observation; paper, sec. 7."""
SERVO_LEAD = 0.1
"""How far ahead [s] a servo aims that follows a motion: about its time constant kd / kp."""
FOOT_WEIGHT, LEG_WEIGHT = 4.0, 2.0
"""How much the feet count among the links, and the legs' joints among the joints; a style lives in them."""
VELOCITY_TIME = 0.1
"""Time [s] that makes a difference of positions of one in velocities, where phases are compared."""
_OBSERVED_PLACE = (0, 1, 2, 7, 8, 9)
"""Positions and velocities among a link's numbers in observations."""
_SMOOTHING = 31
"""Frames (about a second) over which a motion that does not repeat has one direction of travel."""


class Reference(Protocol):
    """States of a reference motion, one every 1/30 s; `adapt_envs`' `ReferenceStates` are some."""

    @property
    def qpos(self) -> NDArray[np.float64]:
        """(P, 7 + J), MuJoCo's."""

    @property
    def qvel(self) -> NDArray[np.float64]:
        """(P, 6 + J), MuJoCo's."""

    @property
    def history(self) -> NDArray[np.float32]:
        """(P, F, L, 13) link states that end in these states, world frame."""

    @property
    def cyclic(self) -> bool:
        """Whether the first state follows the last one."""

    @property
    def mean_speed(self) -> float:
        """Of the root [m/s]."""


@dataclass(frozen=True, eq=False)
class TrackedMotion:
    """A motion of P phases, of one gait or of several. The *travel frame* has its x axis along the direction of travel.

    Attributes:
        gaits: which phases belong together.
        links: link array (13, L, P), heading frame.
        angles: (J, P) of the joints [rad].
        facing: (P,) heading of the root relative to the direction of travel [rad].
        velocity: (2, P) of the root on the ground [m/s], travel frame.
        speeds: (P,) mean speed of the phase's gait [m/s].
        turns: (P,) how far the phase is in its gait, 0 to 2 pi.
        frames: (P, 4 * L * 13) body part of the observation in each phase.
        aims: (P, J) actions whose servos would follow the motion.
        corners: link and point of the soles' C corners; see `corners_of`.
        standing: (C, P) 1 where a corner stands on the ground.
        clearance: (C, P) heights of the corners [m].
        link_weights: (L, 1) how much each link counts, 1 on average.
        joint_weights: (J, 1) the same of the joints.
        seen: (P, L, 6) positions [m] and velocities [m/s] of the links, heading frame: for comparing on the CPU.
    """

    gaits: Gaits
    links: torch.Tensor
    angles: torch.Tensor
    facing: torch.Tensor
    velocity: torch.Tensor
    speeds: torch.Tensor
    turns: torch.Tensor
    frames: torch.Tensor
    aims: torch.Tensor
    corners: tuple[torch.Tensor, torch.Tensor]
    standing: torch.Tensor
    clearance: torch.Tensor
    link_weights: torch.Tensor
    joint_weights: torch.Tensor
    seen: NDArray[np.float32]

    @classmethod
    def of(cls, character: Character, device: torch.device, references: Sequence[Reference]) -> "TrackedMotion":
        """Prepare reference motions.

        Args:
            character: whose motions they are.
            device: where the tensors shall be.
            references: one for each gait.
        """
        parts = [_prepared(character, reference) for reference in references]
        joined = {name: np.concatenate([part[name] for part in parts], axis=-1) for name in parts[0]}
        tensors = {
            name: torch.as_tensor(values, dtype=torch.float32, device=device).contiguous()
            for name, values in joined.items()
        }
        frames, aims = tensors.pop("frames").t().contiguous(), tensors.pop("aims").t().contiguous()
        seen, corners = _seen(joined["links"]), corners_of(character, device)
        return cls(
            gaits=_gaits(character, references, joined["links"], seen),
            frames=frames,
            aims=aims,
            corners=corners,
            standing=standing(tensors["links"], corners),
            clearance=corner_motion(tensors["links"], corners)[0],
            link_weights=_column(_link_weights(character), device),
            joint_weights=_column(_joint_weights(character), device),
            seen=seen,
            **tensors,
        )

    def __len__(self) -> int:
        """P."""
        return len(self.facing)

    def seen_in(self, observations: NDArray[np.float32]) -> NDArray[np.float32]:
        """(N, L, 6) positions [m] and velocities [m/s] of the links, heading frame, from observations (N, 784)."""
        links = self.seen.shape[1]
        size = links * LINK_NUMBERS
        latest = observations[:, (OBSERVED_FRAMES - 1) * size : OBSERVED_FRAMES * size]
        return latest.reshape(-1, links, LINK_NUMBERS)[..., _OBSERVED_PLACE]

    def nearest(self, seen: NDArray[np.floating]) -> NDArray[np.integer]:
        """Phases (n,) that are most like link states (n, L, 6) as `seen` has them."""
        return _nearest(seen, self.seen)


def _prepared(character: Character, reference: Reference) -> dict[str, NDArray[Any]]:
    """Everything of one gait, its phases last."""
    qpos, qvel = reference.qpos, reference.qvel
    frames = reference.history[:, -OBSERVED_FRAMES:].reshape(len(qpos), -1, reference.history.shape[-1])
    view = heading_view(from_observed(torch.as_tensor(frames)), len(character.links))
    travel = _directions(qvel[:, :2], reference.cyclic)
    heading = np.arctan2(view.sin.numpy(), view.cos.numpy())
    aims = qpos[:, 7:] + SERVO_LEAD * qvel[:, 6:]
    return {
        "links": view.latest(len(character.links)).numpy(),
        "angles": qpos[:, 7:].T,
        "facing": (heading - travel + np.pi) % (2 * np.pi) - np.pi,
        "velocity": _turned(qvel[:, :2], -travel).T,
        "speeds": np.full(len(qpos), reference.mean_speed),
        "turns": 2 * np.pi / len(qpos) * np.arange(len(qpos)),
        "frames": to_observed(view.links).numpy().T,
        "aims": ((aims - np.array(character.middles)) / np.array(character.widths)).T,
    }


def _gaits(
    character: Character, references: Sequence[Reference], links: NDArray[np.float32], seen: NDArray[np.float32]
) -> Gaits:
    lengths = np.array([len(reference.qpos) for reference in references])
    starts = np.cumsum(lengths) - lengths
    heights = links[6, _feet(character)]
    spans = [slice(start, start + length) for start, length in zip(starts, lengths, strict=True)]
    return Gaits(
        starts=starts,
        lengths=lengths,
        cyclic=np.array([reference.cyclic for reference in references]),
        speeds=np.array([reference.mean_speed for reference in references]),
        footsteps=np.array(
            [
                footsteps_per_second(heights[:, span], reference.cyclic)
                for span, reference in zip(spans, references, strict=True)
            ]
        ),
        counterparts=_counterparts(seen, spans),
    )


def _counterparts(seen: NDArray[np.float32], spans: Sequence[slice]) -> NDArray[np.integer]:
    if len(spans) == 1:
        return np.arange(len(seen))[None]
    return np.stack([span.start + _nearest(seen, seen[span]) for span in spans])


def _seen(links: NDArray[np.float32]) -> NDArray[np.float32]:
    """(P, L, 6) of a link array (13, L, P): positions and velocities."""
    return np.ascontiguousarray(np.concatenate([links[POSITION], links[VELOCITY]]).transpose(2, 1, 0))


def _nearest(seen: NDArray[np.floating], among: NDArray[np.floating]) -> NDArray[np.integer]:
    """Which of (p, L, 6) is most like each of (n, L, 6): (n,)."""
    scale = np.array([1.0, 1.0, 1.0, *[VELOCITY_TIME] * 3], np.float32)
    here, there = ((part * scale).reshape(len(part), scale.size * part.shape[1]) for part in (seen, among))
    squares = (there * there).sum(axis=1) - 2 * here @ there.T
    return np.asarray(squares.argmin(axis=1))


def _column(values: NDArray[np.float64], device: torch.device) -> torch.Tensor:
    return torch.as_tensor(values, dtype=torch.float32, device=device)[:, None]


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
