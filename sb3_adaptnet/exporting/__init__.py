"""Policies for programs without torch: one ONNX graph of a base and any number of its adaptations."""

from sb3_adaptnet.exporting.adaptations import Exported
from sb3_adaptnet.exporting.extra import onnx_package
from sb3_adaptnet.exporting.onnx_file import OPSET, graph_of, save_onnx, split_weights

__all__ = ["OPSET", "Exported", "graph_of", "onnx_package", "save_onnx", "split_weights"]
