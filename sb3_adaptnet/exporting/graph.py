"""An ONNX graph while it grows: nodes, weights and fresh names."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.exporting.extra import onnx_package

HALVED_FROM = 1024
"""Weights of at least this many numbers are what `half` stores in half precision; statistics and biases stay whole."""


@dataclass
class Graph:
    """Nodes and weights in the order in which they were added, which is one in which they can run.

    Attributes:
        half: whether large weights are stored as float16; all computing stays float32.
        nodes: the nodes (`onnx.NodeProto`).
        weights: name -> values.
        owners: name of a weight -> the part it belongs to: the base or an adaptation.
        part: what the names of further nodes and weights begin with.
    """

    half: bool = False
    nodes: list[Any] = field(default_factory=list)
    weights: dict[str, NDArray[Any]] = field(default_factory=dict)
    owners: dict[str, str] = field(default_factory=dict)
    part: str = ""

    def node(self, kind: str, inputs: Sequence[str], outputs: int = 1, name: str | None = None, **options: Any) -> str:
        """Add a node of the ONNX operator `kind`.

        Args:
            kind: the operator.
            inputs: names of its inputs, "" for one that is left out.
            outputs: how many outputs it has; all but the last are left unused.
            name: name of its output, if that matters.
            **options: its attributes.

        Returns:
            The name of its last output.
        """
        name = name or f"{self.part}/{kind.lower()}_{len(self.nodes)}"
        unused = [""] * (outputs - 1)
        node = onnx_package().helper.make_node(kind, list(inputs), [*unused, name], name=name, **options)
        self.nodes.append(node)
        return name

    def weight(self, name: str, values: torch.Tensor | NDArray[Any]) -> str:
        """Add a weight of the present part; return the name of its float32 (or integer) values.

        Raises:
            ValueError: if the part has another weight of this name.
        """
        array = values.detach().cpu().numpy() if isinstance(values, torch.Tensor) else values
        if not np.issubdtype(array.dtype, np.integer):
            array = array.astype(np.float32)
        full = f"{self.part}/{name}"
        large = self.half and array.dtype == np.float32 and array.size >= HALVED_FROM
        array = np.ascontiguousarray(array.astype(np.float16) if large else array)
        if full in self.weights and not np.array_equal(self.weights[full], array):
            raise ValueError(f"two different weights are named {full!r}")
        self.weights[full] = array
        self.owners[full] = self.part
        return self.node("Cast", [full], to=int(onnx_package().TensorProto.FLOAT)) if large else full

    def integers(self, name: str, values: Sequence[int]) -> str:
        """Add a list of integers, such as a shape."""
        return self.weight(name, np.array(values, np.int64))

    def clip(self, x: str, low: float, high: float, name: str | None = None) -> str:
        """Add `x` clipped to [low, high]."""
        bounds = [self.weight(f"bound_{value:g}", np.array(value, np.float32)) for value in (low, high)]
        return self.node("Clip", [x, *bounds], name=name)

    def linear(self, x: str, name: str, weight: torch.Tensor, bias: torch.Tensor | None) -> str:
        """Add x (N, in) times `weight` (out, in) transposed, plus `bias` (out,)."""
        inputs = [x, self.weight(f"{name}.weight", weight)]
        inputs += [] if bias is None else [self.weight(f"{name}.bias", bias)]
        return self.node("Gemm", inputs, transB=1)

    def column(self, x: str, index: int) -> str:
        """Add column `index` of x (N, K) as (N, 1)."""
        ends = [self.integers(f"{name}_{value}", [value]) for name, value in (("from", index), ("to", index + 1))]
        return self.node("Slice", [x, *ends, self.integers("axis_1", [1])])

    def total(self, terms: Sequence[str]) -> str:
        """Add the sum of `terms`, one or more, which broadcast."""
        return terms[0] if len(terms) == 1 else self.node("Sum", terms)


def inputs_of(graph: Graph, shapes: Mapping[str, Sequence[str | int]]) -> list[Any]:
    """Float inputs that some node of `graph` reads, with their shapes: numbers, or names of free sizes."""
    onnx = onnx_package()
    used = {name for node in graph.nodes for name in node.input}
    kind = onnx.TensorProto.FLOAT
    return [onnx.helper.make_tensor_value_info(name, kind, shape) for name, shape in shapes.items() if name in used]
