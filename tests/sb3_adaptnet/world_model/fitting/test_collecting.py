"""What is recorded is what the physics did; disturbances are drawn anew with every episode."""

import numpy as np
import torch

from adapt_envs import make_vector
from adapt_envs.simulation.physics import PhysicsBatch
from sb3_adaptnet.world_model.fitting.babble import Babble, BabbleSettings
from sb3_adaptnet.world_model.fitting.collecting import collect

JOINTS = ("neck", "right_hip_y", "right_knee", "left_hip_y", "left_knee")
STILL = {"white": (0.0,), "correlated": (0.0,)}


def test_recorded_actions_lead_from_state_to_state():
    env = make_vector("AdaptNet/Humanoid-Walk-v0", 6, max_episode_steps=7, num_threads=1)
    rest = env.single_action_space.mean_pose
    data = collect(env, lambda observations: np.tile(rest, (6, 1)), 20, np.random.default_rng(0))
    assert data.actions.shape == (20, 6, 28)
    assert data.ended[6].all()
    assert not data.ended[:6].all(axis=1).any()
    starts = data.starts(1)
    physics = PhysicsBatch(env.model, len(starts), 1)
    times, worlds = starts.T
    physics.set_states(np.arange(len(starts)), data.qpos[times, worlds], data.qvel[times, worlds])
    physics.step(data.actions[times, worlds])
    moved = np.abs(physics.qpos - data.qpos[times + 1, worlds]).max(axis=1)
    assert np.median(moved) < 1e-4  # single precision, and contacts that start cold
    assert torch.allclose(data.actions_at(starts[:3]), torch.as_tensor(data.actions[times[:3], worlds[:3]]))


def test_without_noise_and_waves_actions_stay_as_they_are():
    babble = Babble(JOINTS, 3, np.random.default_rng(0), BabbleSettings(**STILL, wavy=0))
    actions = np.random.default_rng(1).uniform(-1, 1, (3, 5)).astype(np.float32)
    assert np.allclose(babble.disturbed(actions, np.zeros(5)), actions)


def test_waves_rise_and_swing_by_turns():
    settings = BabbleSettings(**STILL, wavy=1, alternating=1, offset=0, silent=0)
    babble = Babble(JOINTS, 50, np.random.default_rng(0), settings)
    waves = np.stack([babble.disturbed(np.zeros((50, 5)), np.zeros(5)) for _ in range(200)])
    assert np.allclose(waves[0], 0)
    right, left = waves[:, :, 1], waves[:, :, 3]
    by_turns, together = np.abs(right + left).max(axis=0) < 1e-6, np.abs(right - left).max(axis=0) < 1e-6
    assert (by_turns | together).all()  # half a rhythm later is a whole swing for joints that swing twice as fast
    assert by_turns.sum() > together.sum() > 0


def test_noise_has_the_drawn_size_and_memory():
    settings = BabbleSettings(white=(0.0,), correlated=(0.1,), wavy=0)
    babble = Babble(JOINTS, 400, np.random.default_rng(0), settings)
    noise = np.stack([babble.disturbed(np.zeros((400, 5)), np.zeros(5)) for _ in range(60)])[30:]
    assert abs(noise.std() - 0.1) < 0.005
    assert abs((noise[1:] * noise[:-1]).mean() / noise.var() - 0.85) < 0.02
    before = babble._white.copy()
    Babble.restart(babble, np.arange(0))
    assert np.array_equal(babble._white, before)
