"""The networks' encoders as ONNX nodes: normaliser and GRU over the frames, convolutions over the heightmap."""

import torch
from torch import nn

from sb3_adaptnet.exporting.graph import Graph
from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.modules.heightmap import HeightmapEncoder
from sb3_adaptnet.modules.layers.normalizer import CLAMP, RunningNormalizer

FRAMES, GOAL, HEIGHTMAP = "frames", "goal", "heightmap"
"""Names of the observation's parts in the graph; the heightmap is an input."""
CEILING = 6.0
"""Largest output of ReLU6."""


def split_observation(graph: Graph, observation: str, architecture: Architecture) -> None:
    """Add `frames` (frame_count, N, frame_size) and `goal` (N, goal_size) of observations (N, observation_size)."""
    body = architecture.observation_size - architecture.goal_size
    axis, start = graph.integers("columns", [1]), graph.integers("body_from", [0])
    end, last = graph.integers("body_to", [body]), graph.integers("goal_to", [architecture.observation_size])
    frames = graph.node("Slice", [observation, start, end, axis])
    shape = graph.integers("frame_shape", [-1, architecture.frame_count, architecture.frame_size])
    frames = graph.node("Reshape", [frames, shape])
    graph.node("Transpose", [frames], name=FRAMES, perm=[1, 0, 2])
    graph.node("Slice", [observation, end, last, axis], name=GOAL)


def add_state_code(graph: Graph, normalizer: RunningNormalizer, encoder: StateEncoder) -> str:
    """Add the state code (N, gru_size) of the frames."""
    centred = graph.node("Sub", [FRAMES, graph.weight("normalizer.mean", normalizer.mean)])
    scaled = graph.node("Mul", [centred, graph.weight("normalizer.scale", normalizer.scale)])
    frames = graph.clip(scaled, -CLAMP, CLAMP)
    gates = {name: _gates(values)[None] for name, values in encoder.gru.named_parameters()}
    weights = [
        graph.weight("gru.input", gates["weight_ih_l0"]),
        graph.weight("gru.hidden", gates["weight_hh_l0"]),
        graph.weight("gru.bias", torch.cat([gates["bias_ih_l0"], gates["bias_hh_l0"]], dim=1)),
    ]
    # torch's candidate is tanh(W x + b + r (W h + b)): ONNX's "linear before reset".
    last = graph.node("GRU", [frames, *weights], outputs=2, hidden_size=encoder.gru.hidden_size, linear_before_reset=1)
    return graph.node("Squeeze", [last, graph.integers("direction", [0])])


def _gates(values: torch.Tensor) -> torch.Tensor:
    """Rows of a GRU's weights from torch's order, reset, update, new, to ONNX's, update, reset, new."""
    reset, update, new = values.detach().chunk(3)
    return torch.cat([update, reset, new])


def add_heightmap_code(graph: Graph, encoder: HeightmapEncoder) -> str:
    """Add the code (N, 256) of the heightmaps."""
    x = HEIGHTMAP
    for number, layer in enumerate(layer for layer in encoder.layers if isinstance(layer, nn.Conv2d)):
        assert layer.bias is not None
        weight = graph.weight(f"heightmap.{number}.weight", layer.weight)
        bias = graph.weight(f"heightmap.{number}.bias", layer.bias)
        x = graph.node("Conv", [x, weight, bias], strides=list(layer.stride), kernel_shape=list(layer.kernel_size))
        x = relu6(graph, x)
    return graph.node("Flatten", [x], axis=1)


def relu6(graph: Graph, x: str) -> str:
    """Add min(max(x, 0), 6)."""
    return graph.clip(x, 0.0, CEILING)
