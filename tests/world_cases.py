"""Characters and states that the world model's tests share; not a test itself."""

import numpy as np
import torch

from adapt_envs.model.build import compile_model
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.state import State

MODEL = compile_model()
CHARACTER = Character.of(MODEL)


def random_configurations(model, count, seed=0):
    """(count, nq) and (count, nv): anywhere, turned anyhow, joints within their limits."""
    rng = np.random.default_rng(seed)
    qpos = rng.normal(size=(count, model.nq))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    qpos[:, 7:] = rng.uniform(*model.jnt_range[1:].T, size=(count, model.nu))
    return qpos, rng.normal(size=(count, model.nv)) * 3


def random_state(count, seed=0):
    return State.from_mujoco(*(torch.tensor(part) for part in random_configurations(MODEL, count, seed)))
