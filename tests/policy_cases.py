"""Policies, observations and settings that several tests share; not a test itself."""

import numpy as np
import torch
from stable_baselines3 import PPO

from sb3_adaptnet import AdaptNetPolicy, FinetunePolicy, ProgressivePolicy, RegularizedFinetunePolicy

SIZES = {"gru_size": 8, "hidden_sizes": (16, 12)}
PPO_ARGUMENTS = {"n_steps": 32, "batch_size": 16, "n_epochs": 2, "learning_rate": 1e-3, "device": "cpu", "seed": 0}
CHOICES = {
    "adaptnet": (AdaptNetPolicy, {}),
    "z1": (AdaptNetPolicy, {"injection": "z1"}),
    "z2": (AdaptNetPolicy, {"injection": "z2"}),
    "all": (AdaptNetPolicy, {"injection": "all"}),
    "no_encoder": (AdaptNetPolicy, {"own_encoder": False}),
    "no_adaptors": (AdaptNetPolicy, {"adaptors": None}),
    "no_injector": (AdaptNetPolicy, {"injector": False}),
    "lora": (AdaptNetPolicy, {"adaptors": "lora", "rank": 4}),
    "critic_of_base": (AdaptNetPolicy, {"critic": {"encoder": "base", "hidden_sizes": [10]}}),
    "finetune": (FinetunePolicy, {}),
    "finetune_reg": (RegularizedFinetunePolicy, {"kappa": 0.1}),
    "progressive": (ProgressivePolicy, {}),
}
WITH_HEIGHTMAP = ("adaptnet", "critic_of_base", "finetune_reg", "progressive")  # the ways in which one comes in
CASES = [(name, False) for name in CHOICES] + [(name, True) for name in WITH_HEIGHTMAP]


def observations(count=6, heightmap=False, seed=3):
    rng = np.random.default_rng(seed)
    flat = rng.normal(0, 0.5, (count, 784)).astype(np.float32)
    if not heightmap:
        return flat
    return {"observation": flat, "heightmap": rng.normal(size=(count, 1, 35, 35)).astype(np.float32)}


def act(policy, heightmap=False):
    return policy.predict(observations(heightmap=heightmap), deterministic=True)[0]


def adapt(policy_class, env, base_file, **choices):
    return PPO(policy_class, env, policy_kwargs={"base": str(base_file), **choices}, **PPO_ARGUMENTS)


def disturb(module):
    with torch.no_grad():
        for parameter in module.parameters():
            parameter.add_(torch.randn_like(parameter) * 0.1)
