"""Worlds of a run: every training has another terrain, evaluation keeps its own."""

import gymnasium as gym

from sb3_adaptnet.runs import RunSettings
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.worlds import make_worlds, training_ground
from sb3_adaptnet.zoo import ZooVecEnv

HILLS = "AdaptNet/Humanoid-TerrainHills-v0"


def test_a_terrain_that_was_chosen_stays_and_other_suites_have_none():
    assert training_ground(gym.spec(HILLS), 0) == {"terrain_seed": 1} != training_ground(gym.spec(HILLS), 1)
    chosen = gym.make(HILLS, terrain_seed=7).spec
    assert training_ground(chosen, 0) == {} == training_ground(gym.spec("CartPole-v1"), 0)


def test_every_training_samples_its_terrain():
    settings = RunSettings(HILLS, samples=1, seed=3, n_envs=2, threads=1)
    trained = [
        make_worlds(settings, experiment(HILLS)),
        ZooVecEnv([lambda: gym.make(HILLS, terrain_seed=7)] * 2, num_threads=1),
        ZooVecEnv([lambda: gym.make(HILLS)], num_threads=1),  # a single world is rl_zoo3's evaluation
    ]
    assert [env.vector_env.unwrapped.worlds.spec.terrain_seed for env in trained] == [4, 7, 0]
    for env in trained:
        env.close()
