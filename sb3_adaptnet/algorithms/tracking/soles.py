"""How the corners of the soles move, and which of them stand in a reference motion."""

import torch

from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.links import ORIENTATION, POSITION, SPIN, VELOCITY

LOW, SLOW = 0.012, 0.25
"""A corner stands that is lower [m] and slower [m/s] than this."""


def corners_of(character: Character, device: torch.device) -> tuple[torch.Tensor, torch.Tensor]:
    """Link of each of C corners (C,), and its point in the link's frame (3, C, 1) [m]."""
    links = torch.tensor([link for link, _ in character.corners], dtype=torch.long, device=device)
    points = torch.tensor([point for _, point in character.corners], device=device)
    return links, points.view(-1, 3).t().unsqueeze(-1)


def corner_motion(links: torch.Tensor, corners: tuple[torch.Tensor, torch.Tensor]) -> tuple[torch.Tensor, torch.Tensor]:
    """Heights (C, B) [m] and squared speeds over the ground (C, B) [m^2/s^2] of corners on a link array (13, L, B)."""
    of, point = corners
    feet = links.index_select(1, of)
    w, x, z, y = feet[ORIENTATION].unbind(0)
    axis = torch.stack((x, y, z))
    across = torch.linalg.cross(axis, point.expand_as(axis), dim=0)
    arm = point + 2 * (w * across + torch.linalg.cross(axis, across, dim=0))
    velocity = feet[VELOCITY] + torch.linalg.cross(feet[SPIN], arm, dim=0)
    return feet[POSITION][2] + arm[2], velocity[:2].square().sum(0)


def standing(links: torch.Tensor, corners: tuple[torch.Tensor, torch.Tensor]) -> torch.Tensor:
    """(C, B) 1 where a corner stands on the ground, else 0."""
    height, square = corner_motion(links, corners)
    return ((height < LOW) & (square < SLOW * SLOW)).to(links.dtype)
