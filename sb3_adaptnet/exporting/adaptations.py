"""A base with its adaptations as ONNX nodes: how their strengths scale and add up (paper, sec. 8.1)."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import torch
from torch import nn

from sb3_adaptnet.exporting.encoders import GOAL, add_heightmap_code, add_state_code, relu6, split_observation
from sb3_adaptnet.exporting.graph import Graph
from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.adaptation.adaptors import FullAdaptor
from sb3_adaptnet.modules.adaptation.injector import Injector
from sb3_adaptnet.modules.adaptation.lora import LowRankAdaptor
from sb3_adaptnet.modules.architecture import AdaptationShape
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.weights.checkpoint import Base, build_checked, check_base, load_checked, read_adaptation, read_base
from sb3_adaptnet.weights.weight_file import CheckpointError

OBSERVATION, STRENGTHS, ACTION = "observation", "strengths", "action"
"""Names of the graph's inputs and its output."""


@dataclass(frozen=True)
class Exported:
    """What goes into one graph.

    Attributes:
        base: the base.
        adaptations: its adaptations by name, in the order of the strengths.
    """

    base: Base
    adaptations: dict[str, Adaptation]

    @classmethod
    def read(cls, base: str | Path, adaptations: Sequence[str | Path]) -> "Exported":
        """Read a base and adaptations of it, each the name of a shipped one or a file.

        Raises:
            CheckpointError: if one cannot be read, adapts another base, or is no AdaptNet adaptation.
            ValueError: if two of them have one name, by which the graph tells their weights apart.
        """
        found, parts = read_base(base), dict[str, Adaptation]()
        for name in adaptations:
            read = read_adaptation(name)
            check_base(read, found.name, found.hash)
            if read.card.get("method") != "adaptnet":
                raise CheckpointError(f"{str(read.file)!r} was made by {read.card.get('method')!r}, not by 'adaptnet'")
            if read.file.stem in (found.name, *parts):
                owner = "the base" if read.file.stem == found.name else "another adaptation"
                raise ValueError(f"{str(read.file)!r}: {owner} is named {read.file.stem!r}, too; rename the file")
            parts[read.file.stem] = _adaptation(read.file, read.card, read.tensors, found.backbone)
        return cls(found, parts)

    @property
    def reads_heightmap(self) -> bool:
        """Whether the base or one of the adaptations reads a heightmap."""
        return self.base.backbone.architecture.heightmap or any(a.shape.heightmap for a in self.adaptations.values())


def _adaptation(file: Path, card: dict, tensors: dict[str, torch.Tensor], base: Backbone) -> Adaptation:
    shape = build_checked(file, card, lambda: AdaptationShape.from_dict(card["shape"]))
    adaptation = Adaptation(base.architecture, shape)
    load_checked(adaptation, tensors, file)
    return adaptation


def add_policy(graph: Graph, exported: Exported) -> None:
    """Add everything from the observation to the action, the mean of the Gaussian clipped to [-1, 1]."""
    base = exported.base.backbone
    graph.part = exported.base.name
    split_observation(graph, OBSERVATION, base.architecture)
    latent = graph.node("Concat", [add_state_code(graph, base.normalizer, base.encoder), GOAL], axis=1)
    scales = _scales(graph, exported)
    injected = _injections(graph, exported, scales, latent)
    graph.part = exported.base.name
    latent = graph.total([latent, *injected[0]])
    for space, layer in enumerate(cast(list[nn.Linear], base.layers), start=1):
        graph.part = exported.base.name
        terms = [graph.linear(latent, f"layers.{space - 1}", layer.weight, layer.bias), *injected[space]]
        if space == 1 and base.heightmap is not None and base.heightmap_projection is not None:
            code = add_heightmap_code(graph, base.heightmap)
            terms.append(graph.linear(code, "heightmap_projection", base.heightmap_projection.weight, None))
        terms += _increments(graph, exported, scales, latent, space - 1)
        graph.part = exported.base.name
        latent = relu6(graph, graph.total(terms))
    mean = graph.linear(latent, "mean", base.mean.weight, base.mean.bias)
    graph.clip(mean, -1.0, 1.0, name=ACTION)


def _scales(graph: Graph, exported: Exported) -> dict[str, str]:
    """Adaptation -> its column (N or 1, 1) of the strengths."""
    scales = {}
    for index, name in enumerate(exported.adaptations):
        graph.part = name
        scales[name] = graph.column(STRENGTHS, index)
    return scales


def _injections(graph: Graph, exported: Exported, scales: dict[str, str], latent: str) -> dict[int, list[str]]:
    """Latent space -> scaled offsets of the adaptations that inject there (eqs. 4 and 5)."""
    found: dict[int, list[str]] = defaultdict(list)
    for name, adaptation in exported.adaptations.items():
        graph.part = name
        if adaptation.injector is None:
            continue
        code = _injector_code(graph, adaptation.injector, latent)
        maps = cast(list[nn.Linear], adaptation.injector.maps)
        for space, linear in zip(adaptation.injector.spaces, maps, strict=True):
            offset = graph.linear(code, f"maps.{space}", linear.weight, linear.bias)
            found[space].append(graph.node("Mul", [offset, scales[name]]))
    return found


def _injector_code(graph: Graph, injector: Injector, latent: str) -> str:
    code = latent
    if injector.encoder is not None and injector.normalizer is not None:
        code = graph.node("Concat", [add_state_code(graph, injector.normalizer, injector.encoder), GOAL], axis=1)
    if injector.heightmap is not None:
        code = graph.node("Concat", [code, add_heightmap_code(graph, injector.heightmap)], axis=1)
    return code


def _increments(graph: Graph, exported: Exported, scales: dict[str, str], latent: str, layer: int) -> list[str]:
    """Scaled outputs of the adaptations' adaptors beside hidden layer number `layer` (eq. 8)."""
    terms = []
    for name, adaptation in exported.adaptations.items():
        if adaptation.adaptors is None:
            continue
        graph.part = name
        adaptor = cast(FullAdaptor | LowRankAdaptor, adaptation.adaptors[layer])
        weight, bias = adaptor.delta(*adaptor.parameters())
        output = graph.linear(latent, f"adaptors.{layer}", weight, bias)
        terms.append(graph.node("Mul", [output, scales[name]]))
    return terms
