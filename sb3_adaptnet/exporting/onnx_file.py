"""From a base and its adaptations to ONNX files."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sb3_adaptnet.exporting.adaptations import ACTION, OBSERVATION, STRENGTHS, Exported, add_policy
from sb3_adaptnet.exporting.encoders import HEIGHTMAP
from sb3_adaptnet.exporting.extra import onnx_package
from sb3_adaptnet.exporting.graph import Graph, inputs_of
from sb3_adaptnet.exporting.metadata import metadata_of
from sb3_adaptnet.modules.heightmap import HEIGHTMAP_SIZE
from sb3_adaptnet.weights.atomic_file import write_atomically

OPSET, IR_VERSION = 17, 8
"""Versions of ONNX's operators and files: old enough for every runtime of the last years."""
_ALIGNMENT = 16
"""Weights in a file of their own begin at multiples of this many bytes."""
_KEPT = 64
"""Weights of fewer bytes stay in the graph: shapes and bounds, which must be known when it is opened."""


def graph_of(exported: Exported, strengths: Mapping[str, float], half: bool = False) -> Any:
    """One graph (`onnx.ModelProto`) of a base with its adaptations.

    Inputs: `observation` (N, 784); `strengths` (N or 1, number of adaptations) if there are any; `heightmap`
    (N, 1, 35, 35) if one is read. Output: `action` (N, J), in [-1, 1]. All float32.

    Args:
        exported: what goes into it.
        strengths: default strength of each adaptation, for the metadata.
        half: store large weights as float16, which halves the file; computing stays float32.
    """
    onnx, graph = onnx_package(), Graph(half)
    add_policy(graph, exported)
    architecture, size = exported.base.backbone.architecture, HEIGHTMAP_SIZE
    shapes: dict[str, list[str | int]] = {
        OBSERVATION: ["N", architecture.observation_size],
        STRENGTHS: ["N or 1", len(exported.adaptations)],
        HEIGHTMAP: ["N", 1, size, size],
    }
    action = onnx.helper.make_tensor_value_info(ACTION, onnx.TensorProto.FLOAT, ["N", architecture.action_size])
    weights = [onnx.numpy_helper.from_array(values, name) for name, values in graph.weights.items()]
    body = onnx.helper.make_graph(graph.nodes, exported.base.name, inputs_of(graph, shapes), [action], weights)
    opset = onnx.helper.make_opsetid("", OPSET)
    model = onnx.helper.make_model(body, opset_imports=[opset], ir_version=IR_VERSION, producer_name="adaptnet-gym")
    onnx.helper.set_model_props(model, metadata_of(exported, strengths))
    onnx.checker.check_model(model)
    return model


def save_onnx(exported: Exported, file: str | Path, strengths: Mapping[str, float], half: bool = False) -> Path:
    """Write the graph into one file, whole or not at all; see `graph_of`."""
    content = graph_of(exported, strengths, half).SerializeToString()
    path = Path(file)
    write_atomically(path, lambda stream: stream.write(content))
    return path


def split_weights(model: Any) -> tuple[bytes, dict[str, bytes]]:
    """A graph without its weights, and the weights of each of its parts, for programs that load parts when wanted.

    Args:
        model: what `graph_of` returned; it is used up.

    Returns:
        The serialised graph, whose large weights are external data at the location PART.bin, and PART -> its bytes.
        Parts are the base and the adaptations.
    """
    onnx = onnx_package()
    files: dict[str, bytearray] = {}
    for tensor in model.graph.initializer:
        if len(tensor.raw_data) < _KEPT:
            continue
        part = tensor.name.split("/")[0]
        content = files.setdefault(part, bytearray())
        content.extend(bytes(-len(content) % _ALIGNMENT))
        values = tensor.raw_data
        onnx.external_data_helper.set_external_data(tensor, f"{part}.bin", len(content), len(values))
        tensor.ClearField("raw_data")
        tensor.data_location = onnx.TensorProto.EXTERNAL
        content.extend(values)
    return model.SerializeToString(), {part: bytes(content) for part, content in files.items()}
