"""A character in a mirror: left and right exchanged, reflected in the x-z plane of the world."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.world_model.character import Character

_FLIPPED = {0: -1.0, 1: 1.0, 2: -1.0}
"""A reflection in y keeps turns about y and flips those about x and z."""
_LINK_SIGNS = np.array([1, -1, 1, 1, -1, 1, -1, 1, -1, 1, -1, 1, -1], np.float32)
"""Of a link's numbers in observations: position, quaternion (w, x, y, z), velocity, angular velocity."""
_TOLERANCE = 1e-4
"""Measures [m, rad] of left and right that differ by less are equal."""


@dataclass(frozen=True, eq=False)
class Mirror:
    """Exchanges left and right in states, actions and links of a symmetric character.

    Attributes:
        links: (L,) number of each link's twin.
        joints: (J,) number of each joint's twin.
        signs: (J,) what a joint's angle is multiplied by.
    """

    links: NDArray[np.integer]
    joints: NDArray[np.integer]
    signs: NDArray[np.float32]

    @classmethod
    def of(cls, character: Character) -> Self | None:
        """The mirror of a character, or None if its left side is not its right side's reflection."""
        links, joints = _twins(character.links), _twins(character.joints)
        if links is None or joints is None:
            return None
        signs = np.array([_FLIPPED[axis] for _, axis in character.hinges], np.float32)
        middles, widths = np.array(character.middles), np.array(character.widths)
        offsets = np.array(character.offsets)
        pairs = (
            (middles[joints] * signs, middles),
            (widths[joints], widths),
            (offsets[links] * (1, -1, 1), offsets),
        )
        alike = all(np.allclose(there, here, atol=_TOLERANCE) for there, here in pairs)
        return cls(links, joints, signs) if alike else None

    def of_joints(self, values: NDArray[np.floating]) -> NDArray[np.floating]:
        """Angles, rates or actions (..., J)."""
        return values[..., self.joints] * self.signs

    def of_qpos(self, qpos: NDArray[np.floating]) -> NDArray[np.floating]:
        """MuJoCo's positions (..., 7 + J)."""
        root = qpos[..., :7] * np.array([1, -1, 1, 1, -1, 1, -1], qpos.dtype)
        return np.concatenate([root, self.of_joints(qpos[..., 7:])], axis=-1)

    def of_qvel(self, qvel: NDArray[np.floating]) -> NDArray[np.floating]:
        """MuJoCo's velocities (..., 6 + J); the root's angular velocity is in its own frame."""
        root = qvel[..., :6] * np.array([1, -1, 1, -1, 1, -1], qvel.dtype)
        return np.concatenate([root, self.of_joints(qvel[..., 6:])], axis=-1)

    def of_links(self, links: NDArray[np.floating]) -> NDArray[np.floating]:
        """Link states (..., L, 13), world frame, in the order of observations."""
        return links[..., self.links, :] * _LINK_SIGNS


def _twins(names: tuple[str, ...]) -> NDArray[np.integer] | None:
    others = [_other_side(name) for name in names]
    return np.array([names.index(other) for other in others]) if set(others) == set(names) else None


def _other_side(name: str) -> str:
    if name.startswith("left_"):
        return "right_" + name.removeprefix("left_")
    return "left_" + name.removeprefix("right_") if name.startswith("right_") else name
