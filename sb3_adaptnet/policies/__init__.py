"""The Stable-Baselines3 policies: a base from nothing, AdaptNet, and the baselines of the paper."""

from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy
from sb3_adaptnet.policies.baselines import FinetunePolicy, ProgressivePolicy, RegularizedFinetunePolicy, ScratchPolicy
from sb3_adaptnet.policies.from_base import PolicyFromBase
from sb3_adaptnet.policies.loading import load_policy
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.policies.pretrain import PretrainPolicy
from sb3_adaptnet.policies.scaled_adam import ScaledAdam

__all__ = [
    "AdaptNetPolicy",
    "FinetunePolicy",
    "ObjectivePolicy",
    "PolicyFromBase",
    "PretrainPolicy",
    "ProgressivePolicy",
    "RegularizedFinetunePolicy",
    "ScaledAdam",
    "ScratchPolicy",
    "load_policy",
]
