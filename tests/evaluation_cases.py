"""Tiny policies on the real character and recordings made by hand; not a test itself."""

from collections import Counter
from dataclasses import fields

import numpy as np
import torch
from policy_cases import SIZES, disturb

from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import compile_model
from sb3_adaptnet import AdaptNetPolicy, PretrainPolicy, save_adaptation, save_base
from sb3_adaptnet.evaluation.figures import Figures
from sb3_adaptnet.evaluation.recording import Recording, open_worlds

STOOP = "AdaptNet/Humanoid-Stoop-v0"


def no_learning(_):
    return 0.0


def save_tiny_base(folder, name="tiny"):
    """An untrained base that stands in the clip's mean pose and soon falls."""
    env = open_worlds(STOOP, 1, num_threads=1)
    torch.manual_seed(0)
    policy = PretrainPolicy(env.single_observation_space, env.single_action_space, no_learning, **SIZES)
    return save_base(policy, folder / name, environment=STOOP)


def save_tiny_adaptation(base, name, seed=0):
    """An untrained adaptation of a base, beside it."""
    env = open_worlds(STOOP, 1, num_threads=1)
    torch.manual_seed(seed)
    policy = AdaptNetPolicy(env.single_observation_space, env.single_action_space, no_learning, base=base)
    disturb(policy.actor.adaptations)
    return save_adaptation(policy, base.with_name(name), environment=STOOP)


def recording_of(*motions, restarts=(), body=None):
    """A recording of one world per motion (T, nq) of a body; `restarts` are (step, world)."""
    qpos = np.stack(motions, axis=1)
    kinematics = Kinematics(compile_model() if body is None else body)
    links = np.stack([kinematics.link_states(motion) for motion in motions], axis=1)
    steps, worlds = len(qpos) - 1, len(motions)
    ended = np.zeros((steps, worlds), bool)
    for step, world in restarts:
        ended[step, world] = True
    floor, rewards = np.zeros((steps + 1, worlds), np.float32), np.ones((steps, worlds))
    return Recording(qpos, links, floor, ended, rewards, Counter(fall=len(restarts)), 0, 0)


def figures_with(**values):
    """Figures that are None but for `values`."""
    return Figures(**{field.name: None for field in fields(Figures)} | {"failed_tests": ()} | values)
