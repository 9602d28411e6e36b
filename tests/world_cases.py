"""Characters and states that the world model's tests share; not a test itself."""

import numpy as np
import torch

from adapt_envs import make_vector
from adapt_envs.model.build import compile_model
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.state import State
from sb3_adaptnet.world_model.transitions import Transitions

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


def recorded(steps, worlds, seed=0):
    """Transitions of characters that flail about from states of the walk, no episode of which ends."""
    env = make_vector("AdaptNet/Humanoid-Walk-v0", worlds, max_episode_steps=None, num_threads=1)
    env.reset(seed=seed)
    rng, physics = np.random.default_rng(seed), env.worlds.physics
    actions = np.float32(env.single_action_space.mean_pose + rng.normal(0, 0.1, (steps, worlds, physics.model.nu)))
    states = [(physics.qpos.copy(), physics.qvel.copy())]
    for action in actions:
        env.worlds.step(action, None)
        states.append((physics.qpos.copy(), physics.qvel.copy()))
    qpos, qvel = (np.stack(part).astype(np.float32) for part in zip(*states, strict=True))
    return Transitions(qpos, qvel, actions, np.zeros((steps, worlds), bool))
