"""The paper's baselines (sec. 8.1) behind the same interface; "Scratch" is `PretrainPolicy`."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from torch import nn

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.adaptation.anchored import AnchoredActor
from sb3_adaptnet.modules.adaptation.progressive import ProgressiveActor
from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.policies.from_base import PolicyFromBase
from sb3_adaptnet.policies.pretrain import PretrainPolicy
from sb3_adaptnet.weights.checkpoint import ADAPTATION, BASE, check_base, load_checked, read_adaptation

ScratchPolicy = PretrainPolicy


class FinetunePolicy(PolicyFromBase):
    """FT: trains all weights of the base but its log-std head, so that all methods explore alike.

    Inputs are normalised as the base's are.
    Where the observations bring a heightmap that the base cannot read, an encoder is added whose output starts at zero.
    """

    actor: Backbone
    keeps_statistics = True

    def __init__(self, *args: Any, noise: float = 1.0, **settings: Any) -> None:
        """As `PolicyFromBase`, with a factor `noise` on the standard deviations of the base's actions; above 0."""
        self.noise = float(noise)
        super().__init__(*args, **settings)

    def adapt(self, base: Backbone) -> Actor:
        """A copy of the base that learns, with its own noise."""
        copy = finetuned_copy(base, self.reads_heightmap)
        copy.scale_std(self.noise)
        return copy

    def actor_from(self, description: Mapping[str, Any]) -> Actor:
        """A network of the described sizes."""
        return _learning(Backbone(Architecture.from_dict(description["architecture"])))

    def export(self) -> tuple[str, nn.Module, dict[str, Any]]:
        """The whole network, as a base."""
        return BASE, self.actor, self.describe_actor() | {"method": "finetune"}

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return super()._get_constructor_parameters() | {"noise": self.noise}


class RegularizedFinetunePolicy(PolicyFromBase):
    """FT + Reg: finetuning with the penalty kappa * ||theta - theta_base||_2."""

    actor: AnchoredActor
    keeps_statistics = True

    def __init__(self, *args: Any, kappa: float = 0.01, **settings: Any) -> None:
        """As `PolicyFromBase`, with the penalty's coefficient `kappa`."""
        self.kappa = kappa
        super().__init__(*args, **settings)

    def adapt(self, base: Backbone) -> Actor:
        """A copy of the base that learns, and the base."""
        return AnchoredActor(finetuned_copy(base, self.reads_heightmap), base, self.kappa)

    def actor_from(self, description: Mapping[str, Any]) -> Actor:
        """Two networks of the described sizes; the base's heightmap is its own matter."""
        architecture = Architecture.from_dict(description["architecture"])
        base = Backbone(replace(architecture, heightmap=description["base_heightmap"]))
        return AnchoredActor(_learning(Backbone(architecture)), base, self.kappa)

    def describe_actor(self) -> dict[str, Any]:
        """Sizes of both networks, and the base's identity."""
        return super().describe_actor() | {"base_heightmap": self.actor.base.architecture.heightmap}

    def export(self) -> tuple[str, nn.Module, dict[str, Any]]:
        """The network that learned, as a base."""
        return BASE, self.actor.network, super().describe_actor() | {"method": "finetune-reg"}


class ProgressivePolicy(PolicyFromBase):
    """PNet: a new column that reads the frozen base's latents; it starts at random."""

    actor: ProgressiveActor

    def adapt(self, base: Backbone) -> Actor:
        """The base and a fresh column, whose mean head starts at the base's bias."""
        actor = ProgressiveActor(base, self.reads_heightmap)
        actor.start_from_base()
        return actor

    def actor_from(self, description: Mapping[str, Any]) -> Actor:
        """Base and column of the described sizes."""
        return ProgressiveActor(
            Backbone(Architecture.from_dict(description["architecture"])), description["column_heightmap"]
        )

    def describe_actor(self) -> dict[str, Any]:
        """Sizes and identity of the base, and whether the column reads a heightmap."""
        heightmap = self.actor.column.architecture.heightmap
        return super().describe_actor() | {"column_heightmap": heightmap}

    def export(self) -> tuple[str, nn.Module, dict[str, Any]]:
        """The column and its laterals, without the base."""
        return ADAPTATION, self._added(), self.describe_actor() | {"method": "progressive"}

    def load_adaptation(self, name_or_file: str | Path) -> None:
        """Replace the column's weights by those of a file.

        Raises:
            CheckpointError: if it cannot be read, adapts another base or has other sizes.
        """
        read = read_adaptation(name_or_file)
        check_base(read, self.base_name, self.base_hash)
        load_checked(self._added(), read.tensors, read.file)

    def _added(self) -> nn.Module:
        return nn.ModuleDict({"column": self.actor.column, "laterals": self.actor.laterals})


def finetuned_copy(base: Backbone, heightmap: bool) -> Backbone:
    """A copy of a base that learns, with the same outputs; `heightmap` adds an encoder that starts at zero."""
    network = Backbone(replace(base.architecture, heightmap=base.architecture.heightmap or heightmap))
    network.load_state_dict(base.state_dict(), strict=False)
    if network.heightmap_projection is not None and not base.architecture.heightmap:
        nn.init.zeros_(network.heightmap_projection.weight)
    return _learning(network)


def _learning(network: Backbone) -> Backbone:
    network.requires_grad_(True).log_std.requires_grad_(False)
    return network
