"""AdaptNet on stock Stable-Baselines3 PPO: policies, discriminators, files."""

from sb3_adaptnet import openmp as openmp  # first: it must be read before torch is imported
from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy
from sb3_adaptnet.policies.baselines import FinetunePolicy, ProgressivePolicy, RegularizedFinetunePolicy, ScratchPolicy
from sb3_adaptnet.policies.loading import load_policy
from sb3_adaptnet.policies.pretrain import PretrainPolicy
from sb3_adaptnet.runs.experiment import callbacks, hyperparameters
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.weights.checkpoint import save_adaptation, save_base
from sb3_adaptnet.weights.weight_file import CheckpointError

__all__ = [
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
    "callbacks",
    "hyperparameters",
    "load_policy",
    "save_adaptation",
    "save_base",
]
