"""Frozen adaptations that act while another one learns, each in worlds of its own: what learns beside them stacks."""

from collections.abc import Sequence
from typing import cast

import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.observation import Observation

Layers = list[tuple[torch.Tensor, torch.Tensor]]
"""(Delta W, Delta b) of every hidden layer."""


class Companions(nn.Module):
    """Frozen adaptations of one base. The observation says which one acts in its world: 1, 2, ..., or 0 for none.

    What they add is what a sum with weight 1 adds (`AdaptedActor.blend`), computed for the rows of each together.

    Attributes:
        members: the adaptations, in order.
    """

    def __init__(self, adaptations: Sequence[Adaptation]) -> None:
        """Freeze the adaptations.

        Raises:
            ValueError: for one that injects into other latents than z0.
        """
        super().__init__()
        for adaptation in adaptations:
            if adaptation.shape.injector and adaptation.shape.injection != "z0":
                raise ValueError(f"a companion injects into z0, not into {adaptation.shape.injection!r}")
        self.members = nn.ModuleList(adaptations).requires_grad_(False)

    def __len__(self) -> int:
        return len(self.members)

    def parts(self) -> list[Adaptation]:
        """The adaptations, in order."""
        return [cast(Adaptation, member) for member in self.members]

    @torch.no_grad()
    def offsets(self, observation: Observation, base_latent: torch.Tensor) -> torch.Tensor:
        """What each row's companion adds to z0, (B, gru_size + goal_size), float32.

        It depends on nothing that learns, so it is computed once per sample and comes back with the observation.
        """
        rows_of = _Rows(observation.companion, len(self))
        offsets = torch.zeros_like(base_latent)
        for adaptation, rows in zip(self.parts(), rows_of.each()[1:], strict=True):
            if len(rows) and adaptation.injector is not None:
                heightmap = observation.heightmap[rows] if observation.heightmap is not None else None
                own = Observation(observation.frames[rows], observation.goal[rows], heightmap)
                offsets[rows] = adaptation.injector(own, base_latent[rows])[0]
        return offsets

    def acting(self, observation: Observation, base_latent: torch.Tensor) -> "ActingCompanions":
        """The companions of a batch."""
        known = observation.companion_offset
        offset = self.offsets(observation, base_latent) if known is None else known
        layers = [adaptation.increments(0.0) for adaptation in self.parts()]
        return ActingCompanions(offset, _Rows(observation.companion, len(self)), layers)


class ActingCompanions:
    """What the companions of one batch add.

    Attributes:
        offset: to z0, (B, gru_size + goal_size).
    """

    def __init__(self, offset: torch.Tensor, rows: "_Rows", layers: Sequence[Layers]) -> None:
        """Keep the increments of each companion's layers; one without adaptors has none."""
        self.offset = offset
        self._rows, self._layers = rows, layers

    def output(self, space: int, latent: torch.Tensor, like: torch.Tensor) -> torch.Tensor:
        """What is added to the output of layer `space` (from 1) for latents (B, in); zeros are made `like` it."""
        parts = latent[self._rows.order].split(self._rows.sizes)
        outputs = [like.new_zeros(len(parts[0]), like.shape[1])]
        for layers, part in zip(self._layers, parts[1:], strict=True):
            if layers and len(part):
                outputs.append(functional.linear(part, *layers[space - 1]))
            else:
                outputs.append(like.new_zeros(len(part), like.shape[1]))
        return torch.cat(outputs)[self._rows.back]


class _Rows:
    """Which rows of a batch have which companion.

    Attributes:
        order: the rows (B,), those of the same companion together.
        back: where each row of the batch (B,) is in that order.
        sizes: how many rows each companion has, none's first.
    """

    def __init__(self, companion: torch.Tensor | None, count: int) -> None:
        if companion is None:
            raise ValueError("observations do not say which companion acts: companions need JoinedWorlds")
        self.order = torch.argsort(companion, stable=True)
        self.back = torch.argsort(self.order)
        self.sizes: list[int] = torch.bincount(companion, minlength=count + 1).tolist()

    def each(self) -> Sequence[torch.Tensor]:
        """The rows of each companion, none's first."""
        return self.order.split(self.sizes)
