"""AdaptNet on stock Stable-Baselines3 PPO: policies, discriminators, files."""

from sb3_adaptnet import openmp as openmp  # first: it must be read before torch is imported
from sb3_adaptnet.baselines import FinetunePolicy, ProgressivePolicy, RegularizedFinetunePolicy, ScratchPolicy
from sb3_adaptnet.callback import DiscriminatorRewardCallback
from sb3_adaptnet.checkpoint import save_adaptation, save_base
from sb3_adaptnet.hyperparameters import callbacks, hyperparameters
from sb3_adaptnet.loading import load_policy
from sb3_adaptnet.policy import AdaptNetPolicy
from sb3_adaptnet.pretraining import PretrainPolicy
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.weight_file import CheckpointError

__all__ = [
    "AdaptNetPolicy",
    "AdaptVecEnv",
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
