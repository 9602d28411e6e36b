"""AdaptNet on stock Stable-Baselines3 PPO, or on SVG through a world model: policies, discriminators, files."""

from sb3_adaptnet import openmp as openmp  # first: it must be read before torch is imported
from sb3_adaptnet.algorithms import SVG
from sb3_adaptnet.objectives import AttributeRamp, DiscriminatorRewardCallback, WeightAveraging
from sb3_adaptnet.policies import (
    AdaptNetPolicy,
    FinetunePolicy,
    PretrainPolicy,
    ProgressivePolicy,
    RegularizedFinetunePolicy,
    ScratchPolicy,
    load_policy,
)
from sb3_adaptnet.runs import callbacks, hyperparameters
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.weights import CheckpointError, save_adaptation, save_base

__all__ = [
    "SVG",
    "AdaptNetPolicy",
    "AdaptVecEnv",
    "AttributeRamp",
    "CheckpointError",
    "DiscriminatorRewardCallback",
    "FinetunePolicy",
    "PretrainPolicy",
    "ProgressivePolicy",
    "RegularizedFinetunePolicy",
    "ScratchPolicy",
    "WeightAveraging",
    "callbacks",
    "hyperparameters",
    "load_policy",
    "save_adaptation",
    "save_base",
]
