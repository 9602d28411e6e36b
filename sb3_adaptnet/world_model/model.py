"""The world model: kinematics that are exact, dynamics that are learned, one control step at a time."""

import copy
from collections.abc import Mapping
from typing import NamedTuple

import torch
from torch import nn

from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.dynamics import Dynamics
from sb3_adaptnet.world_model.integration import change_between, change_size, integrate
from sb3_adaptnet.world_model.kinematics import Kinematics
from sb3_adaptnet.world_model.links import LINK_NUMBERS, ORIENTATION, HeadingView, heading_view, to_observed
from sb3_adaptnet.world_model.state import State

TOUCH_SCALES = (0.01, 0.03)
"""Heights [m] at which a sole's corner is told to be near the ground: contact is decided within centimetres."""


class Sizes(NamedTuple):
    """Sizes of the dynamics network: `depth` hidden layers of `width` numbers."""

    width: int = 512
    depth: int = 3

    @classmethod
    def of(cls, weights: Mapping[str, torch.Tensor]) -> "Sizes":
        """The sizes of a model whose `state_dict` this is."""
        depth = sum(name.startswith("dynamics.layers.") and name.endswith(".weight") for name in weights)
        return cls(weights["dynamics.last.weight"].shape[1], depth)


class WorldModel(nn.Module):
    """What a character does next, on flat ground, as a differentiable function of its state and its action.

    The dynamics read (B, I), everything in the heading frame and in SI units:

        13 L   the links as an observation has them
        J      joint angles [rad]
        J      joint rates [rad/s]
        J      servo errors (aim - angle) / width of the joint's range
        3 C    heights of the soles' C corners [m], then tanh(height / 1 cm) and tanh(height / 3 cm)

    and give a change; see `integration`.

    Attributes:
        character: whose model this is.
        sizes: of the network.
        kinematics: state -> links.
        dynamics: the network.
    """

    middles: torch.Tensor
    widths: torch.Tensor
    feet: torch.Tensor
    corners: torch.Tensor

    def __init__(self, character: Character, sizes: Sizes | None = None) -> None:
        super().__init__()
        self.character, self.sizes = character, sizes or Sizes()
        self.kinematics = Kinematics(character)
        links, joints, corners = len(character.links), len(character.joints), len(character.corners)
        inputs = LINK_NUMBERS * links + 3 * joints + (1 + len(TOUCH_SCALES)) * corners
        self.dynamics = Dynamics(inputs, change_size(joints), *self.sizes)
        self.register_buffer("middles", torch.tensor(character.middles), persistent=False)
        self.register_buffer("widths", torch.tensor(character.widths), persistent=False)
        feet, points = [link for link, _ in character.corners], [point for _, point in character.corners]
        self.register_buffer("feet", torch.tensor(feet, dtype=torch.long), persistent=False)
        self.register_buffer("corners", torch.tensor(points).view(-1, 3).t().unsqueeze(-1), persistent=False)

    def view(self, frames: torch.Tensor) -> HeadingView:
        """Link arrays (13, F * L, B) in the world, seen from the heading frame of their last root."""
        return heading_view(frames, len(self.character.links))

    def inputs(self, view: HeadingView, state: State, actions: torch.Tensor) -> torch.Tensor:
        """What the dynamics read, (B, I).

        Args:
            view: links up to now in the heading frame; the last frame's are read.
            state: the state.
            actions: (B, J) in [-1, 1].
        """
        body, soles = self._seen(view, state)
        errors = actions - (state.angles.t() - self.middles) / self.widths
        return torch.cat((body, errors, soles), dim=1)

    def posture(self, view: HeadingView, state: State) -> torch.Tensor:
        """The inputs (B, I - J) but the servo errors, normalised and clipped as the dynamics do it."""
        body, soles = self._seen(view, state)
        parts = (body, torch.zeros_like(state.angles.t()), soles)
        seen = self.dynamics.normalised(torch.cat(parts, dim=1))
        body, _, soles = seen.split([part.shape[1] for part in parts], dim=1)
        return torch.cat((body, soles), dim=1)

    def _seen(self, view: HeadingView, state: State) -> tuple[torch.Tensor, torch.Tensor]:
        """Links, angles and rates (B, 13 L + 2 J), and the soles (B, 3 C)."""
        links = view.latest(len(self.character.links))
        heights = self._corner_heights(links)
        touches = [torch.tanh(heights / scale) for scale in TOUCH_SCALES]
        return torch.cat((to_observed(links), state.angles.t(), state.rates.t()), 1), torch.cat((heights, *touches), 1)

    def _corner_heights(self, links: torch.Tensor) -> torch.Tensor:
        """(B, C) heights of the soles' corners over the ground [m]."""
        feet = links.index_select(1, self.feet)
        w, x, z, y = feet[ORIENTATION].unbind(0)
        up = torch.stack((2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
        return ((up * self.corners).sum(0) + feet[6]).t()

    def change(self, view: HeadingView, state: State, actions: torch.Tensor) -> torch.Tensor:
        """The change (B, 12 + 2 J) that the model expects of one control step."""
        return self.dynamics(self.inputs(view, state, actions))

    @torch.no_grad()
    def residual(self, before: State, after: State, actions: torch.Tensor) -> torch.Tensor:
        """(B, 12 + 2 J) what a real step changed beyond what the model expects of it."""
        view = self.view(self.kinematics(before))
        return change_between(before, after, view) - self.change(view, before, actions)

    def step(
        self, state: State, view: HeadingView, actions: torch.Tensor, residual: torch.Tensor | None = None
    ) -> State:
        """The state one control step later.

        Args:
            state: the state.
            view: its links, and maybe earlier ones, in the heading frame.
            actions: (B, J) in [-1, 1].
            residual: (B, 12 + 2 J) that `residual` gave: with it and the same action the step is the real one.
        """
        change = self.change(view, state, actions)
        return integrate(state, change if residual is None else change + residual, view)

    def frozen(self) -> "WorldModel":
        """A copy that does not learn: for slopes in states and actions, and for nothing else."""
        twin = copy.deepcopy(self).requires_grad_(False)
        twin.dynamics.shorten()
        return twin
