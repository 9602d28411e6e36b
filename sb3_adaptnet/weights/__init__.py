"""Weights on disk: safetensors files with cards, and those that ship."""

from sb3_adaptnet.weights.atomic_file import write_atomically
from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.checkpoint import AdaptationFile, Base, read_adaptation, read_base, save_adaptation, save_base
from sb3_adaptnet.weights.shipped import pretrained_names, pretrained_path, zoo_config_path
from sb3_adaptnet.weights.weight_file import CheckpointError, read_weights, write_weights

__all__ = [
    "AdaptationFile",
    "Base",
    "CheckpointError",
    "amend_card",
    "pretrained_names",
    "pretrained_path",
    "read_adaptation",
    "read_base",
    "read_weights",
    "save_adaptation",
    "save_base",
    "write_atomically",
    "write_weights",
    "zoo_config_path",
]
