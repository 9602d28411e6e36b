"""Differentiable forward kinematics: from generalised coordinates to the states of the links, as MuJoCo has them."""

import torch
from torch import nn

from sb3_adaptnet.world_model.character import AXES, Character
from sb3_adaptnet.world_model.rotations import cross, multiply, rotate
from sb3_adaptnet.world_model.state import State


class Kinematics(nn.Module):
    """The links' states as a function of the character's state.

    Links without a hinge turn with their parent. The others, the *turning* ones, are taken level by level: all that
    have as many turning links above them in one product.

    Attributes:
        character: whose kinematics these are.
    """

    hinge_columns: torch.Tensor
    order: torch.Tensor
    turning_parents: torch.Tensor
    parents: torch.Tensor
    offsets: torch.Tensor
    above: torch.Tensor
    turning_above: torch.Tensor

    def __init__(self, character: Character) -> None:
        super().__init__()
        self.character = character
        turning = sorted({link for link, _ in character.hinges})
        paths = [_path(character.parents, link) for link in range(len(character.links))]
        self._levels = len(_add_levels(self, paths, turning))
        columns = torch.full((len(AXES), len(turning)), len(character.joints))
        for joint, (link, axis) in enumerate(character.hinges):
            columns[axis, turning.index(link)] = joint
        self._constant("hinge_columns", columns.flatten())
        self._constant("turning_parents", torch.tensor([character.parents[link] for link in turning]))
        self._constant("parents", torch.tensor(character.parents[1:]))
        self._constant("offsets", torch.tensor(character.offsets[1:]).t().unsqueeze(-1))
        links = range(1, len(character.links))
        self._constant("above", torch.tensor([[float(link in path) for link in links] for path in paths]))
        self._constant("turning_above", torch.tensor([[float(link in path) for link in turning] for path in paths]))

    def _constant(self, name: str, value: torch.Tensor) -> None:
        self.register_buffer(name, value, persistent=False)

    def forward(self, state: State) -> torch.Tensor:
        """Link array (13, L, B) in the world frame, of B states."""
        cos, sin, rates = self._hinges(state)
        orientation = self._orientations(state.orientation, _intrinsic_xyz(cos, sin))
        relative = rotate(orientation.index_select(1, self.turning_parents), _relative_spin(cos, sin, rates))
        spin = torch.matmul(self.turning_above, relative) + state.spin.unsqueeze(1)
        arms = rotate(orientation.index_select(1, self.parents), self.offsets)
        position = torch.matmul(self.above, arms) + state.position.unsqueeze(1)
        swing = cross(spin.index_select(1, self.parents), arms)
        velocity = torch.matmul(self.above, swing) + state.velocity.unsqueeze(1)
        vectors = torch.stack((position, velocity, spin), dim=1).flatten(0, 1)  # x, vx, wx, y, ...
        return torch.cat((vectors, orientation[:2], orientation[3:], orientation[2:3]))

    def _hinges(self, state: State) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Cosine and sine of half the angles, and the rates [rad/s], each (3, turning links, B); 0 without a hinge."""
        shape = (len(AXES), -1, state.angles.shape[-1])
        nothing = torch.zeros_like(state.angles[:1])
        half = torch.cat((state.angles, nothing)).index_select(0, self.hinge_columns).view(shape) / 2
        rates = torch.cat((state.rates, nothing)).index_select(0, self.hinge_columns).view(shape)
        return torch.cos(half), torch.sin(half), rates

    def _orientations(self, root: torch.Tensor, turns: torch.Tensor) -> torch.Tensor:
        """Orientations (4, L, B) in the world from the root's (4, B) and the turning links' own turns (4, ., B)."""
        levels = [root.unsqueeze(1)]
        for level in range(self._levels):
            above = levels[-1].index_select(1, getattr(self, f"level_{level}_above"))
            levels.append(multiply(above, turns.index_select(1, getattr(self, f"level_{level}"))))
        return torch.cat(levels, dim=1).index_select(1, self.order)


def _path(parents: tuple[int, ...], link: int) -> list[int]:
    """Links from `link` up to the root, which is left out."""
    path = []
    while link > 0:
        path.append(link)
        link = parents[link]
    return path


def _add_levels(module: Kinematics, paths: list[list[int]], turning: list[int]) -> list[list[int]]:
    """Register the turning links of each level, the rows of those above them, and the order of all orientations.

    Returns:
        The levels, as turning links.
    """
    chains = [[link for link in path if link in turning] for path in paths]  # nearest first, with the link itself
    depth = max(len(chain) for chain in chains)
    levels = [[0], *([link for link in turning if len(chains[link]) == level] for level in range(1, depth + 1))]
    for level, (above, links) in enumerate(zip(levels[:-1], levels[1:], strict=True)):
        rows = [above.index((*chains[link][1:], 0)[0]) for link in links]
        module._constant(f"level_{level}", torch.tensor([turning.index(link) for link in links]))
        module._constant(f"level_{level}_above", torch.tensor(rows))
    stacked = [link for level in levels for link in level]
    module._constant("order", torch.tensor([stacked.index((*chain, 0)[0]) for chain in chains]))
    return levels[1:]


def _intrinsic_xyz(cos: torch.Tensor, sin: torch.Tensor) -> torch.Tensor:
    """Quaternions (4, n, B) of the turns Rx Ry Rz from cosines and sines (3, n, B) of half their angles."""
    cx, cy, cz = cos.unbind(0)
    sx, sy, sz = sin.unbind(0)
    cc, ss, sc, cs = cx * cy, sx * sy, sx * cy, cx * sy
    return torch.stack((cc * cz - ss * sz, sc * cz + cs * sz, cs * cz - sc * sz, ss * cz + cc * sz))


def _relative_spin(cos: torch.Tensor, sin: torch.Tensor, rates: torch.Tensor) -> torch.Tensor:
    """Angular velocities (3, n, B) [rad/s] relative to the parents, in the parents' frames; arguments (3, n, B).

    The x axis is the parent's, the y axis is turned by Rx, the z axis by Rx Ry.
    """
    (cx, cy, _), (sx, sy, _) = cos.unbind(0), sin.unbind(0)
    cos_x, sin_x, cos_y, sin_y = 1 - 2 * sx * sx, 2 * sx * cx, 1 - 2 * sy * sy, 2 * sy * cy
    x, y, z = rates.unbind(0)
    return torch.stack((x + sin_y * z, cos_x * y - sin_x * cos_y * z, sin_x * y + cos_x * cos_y * z))
