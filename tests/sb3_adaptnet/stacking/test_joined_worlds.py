"""Worlds of several tasks as one batch: what the groups say, in order, and of which group each world is."""

import numpy as np
import pytest
from gymnasium import spaces
from stable_baselines3.common.monitor import Monitor
from toy_env import ToyVectorEnv

from sb3_adaptnet import AdaptVecEnv
from sb3_adaptnet.objectives.attribute_ramp import set_in_worlds
from sb3_adaptnet.objectives.pose_windows import pose_windows, reference_windows
from sb3_adaptnet.stacking import JoinedWorlds, worlds_with_companions

ICE = "AdaptNet/Humanoid-IceWalk-v0"


def groups(heightmap=False):
    return [AdaptVecEnv(ToyVectorEnv(count, heightmap)) for count in (3, 2, 1)]


@pytest.mark.parametrize("heightmap", [False, True])
def test_equals_its_groups_one_after_the_other(heightmap):
    joined, apart, rng = JoinedWorlds(groups(heightmap)), groups(heightmap), np.random.default_rng(0)
    joined.seed(7)
    for number, group in enumerate(apart):
        group.seed(7 + 1000 * number)
    numbers = np.array([0, 0, 0, 1, 1, 2])
    observations, expected, ended = joined.reset(), [group.reset() for group in apart], 0
    for _ in range(50):
        assert observations.keys() == joined.observation_space.spaces.keys()
        np.testing.assert_array_equal(observations["companion"], numbers)
        for key in observations.keys() - {"companion"}:
            parts = [part[key] if heightmap else part for part in expected]
            np.testing.assert_array_equal(observations[key], np.concatenate(parts))
        actions = rng.uniform(-1, 1, (6, 28)).astype(np.float32)
        observations, rewards, dones, infos = joined.step(actions)
        stepped = [group.step(actions[numbers == number]) for number, group in enumerate(apart)]
        expected = [step[0] for step in stepped]
        np.testing.assert_array_equal(rewards, np.concatenate([step[1] for step in stepped]))
        np.testing.assert_array_equal(dones, np.concatenate([step[2] for step in stepped]))
        assert pose_windows(joined).shape[0] == 6
        for world in np.flatnonzero(dones):
            last = infos[world]["terminal_observation"]
            assert last["companion"] == numbers[world] and last["observation"].shape == (784,)
            assert joined.observation_space.contains({**last, "companion": np.int64(last["companion"])})
            ended += 1
    assert ended > 0
    joined.close()


def test_options_reach_every_group_and_parts_of_the_worlds_are_refused():
    joined = JoinedWorlds([AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=2, num_threads=1) for _ in range(2)])
    joined.set_options({"goal_heading": 0.0, "goal_speed": 1.4})
    joined.reset()
    assert [group.simulation.goal_states.speed.tolist() for group in joined.groups] == [pytest.approx([1.4, 1.4])] * 2
    with pytest.raises(ValueError, match="'goal_spread' can only be set for all 4 worlds at once"):
        joined.set_attr("goal_spread", 0.5, indices=[0])
    joined.close()


def test_numbers_are_a_discrete_space_and_spaces_must_agree():
    assert JoinedWorlds(groups()).observation_space["companion"] == spaces.Discrete(3)
    with pytest.raises(ValueError, match="no worlds"):
        JoinedWorlds([])
    with pytest.raises(ValueError, match="cannot join"):
        JoinedWorlds([groups()[0], groups(heightmap=True)[0]])


def test_reference_windows_come_from_all_groups_in_proportion():
    joined = JoinedWorlds(groups())
    for number, group in enumerate(joined.groups):
        group.vector_env.sample_reference_windows = lambda n, rng, k=number: np.full((n, 5, 15, 7), k, np.float32)
    windows = reference_windows(joined, 6000, np.random.default_rng(0))
    shares = np.bincount(windows[:, 0, 0, 0].astype(int)) / 6000
    assert np.abs(shares - [3 / 6, 2 / 6, 1 / 6]).max() < 0.03
    assert windows.shape == (6000, 5, 16, 7)
    np.testing.assert_array_equal(windows[:, :, 15].argmax(axis=-1), windows[:, :, 0, 0])
    np.testing.assert_array_equal(windows[:, :, 15].sum(axis=-1), 1.0)


def test_windows_say_of_which_group_they_are():
    joined = JoinedWorlds([AdaptVecEnv(ToyVectorEnv(1)) for _ in range(9)])
    joined.reset()
    marks = pose_windows(joined)[:, :, 15:]
    assert marks.shape == (9, 5, 2, 7)
    np.testing.assert_array_equal(marks.reshape(9, 5, 14)[:, 0, :9], np.eye(9))
    np.testing.assert_array_equal(
        pose_windows(joined)[:, :, :15], np.concatenate([g.pose_windows for g in joined.groups])
    )


def test_a_companion_brings_its_motion_and_speeds_and_the_first_group_is_twice_as_large():
    worlds = worlds_with_companions(["walk-penguin", "walk-stoop"], env=ICE, num_envs=9, num_threads=1)
    specs = [group.vector_env.unwrapped.worlds.spec for group in worlds.groups]
    assert [group.num_envs for group in worlds.groups] == [5, 2, 2]
    assert [spec.motion for spec in specs] == ["walk", "Penguin", "Stoop"]
    assert [spec.speed_range for spec in specs] == [(1.0, 1.5), (0.51, 0.765), (0.743, 1.114)]
    assert {spec.friction for spec in specs} == {0.15}
    set_in_worlds(worlds, "goal_spread", np.linspace(0.1, 0.9, 9))
    np.testing.assert_allclose(worlds.get_attr("goal_spread"), np.linspace(0.1, 0.9, 9))
    assert worlds.env_is_wrapped(Monitor) == [True] * 9
    worlds.close()


def test_one_world_for_each_at_least():
    worlds = worlds_with_companions(["walk-penguin"], env=ICE, num_envs=1, num_threads=1)
    assert [group.num_envs for group in worlds.groups] == [1, 1]
    worlds.close()


@pytest.mark.parametrize(
    "companions, complaint",
    [
        (["walk"], "'walk' is a base"),
        (["walk-moonwalk"], "no pretrained weights named 'walk-moonwalk'"),
        ("walk-penguin", "companions are 'walk-penguin', expected a list"),
        (["walk-penguin", 3], "expected a list of adaptations' names or files"),
        (["walk-terrainhills"], "cannot join"),
    ],
)
def test_what_is_no_companion_is_named(companions, complaint):
    with pytest.raises(ValueError, match=complaint):
        worlds_with_companions(companions, env=ICE, num_envs=4, num_threads=1)


def test_reference_windows_are_shown_by_the_worlds_own_body():
    shown, plain = (
        worlds_with_companions([], 1, env="AdaptNet/Humanoid-LongBodyWalk-v0", num_threads=1, **kwargs)
        for kwargs in ({}, {"clip_on_body": False})
    )
    heights = [env.sample_reference_windows(20, np.random.default_rng(0))[:, -1, 2, 2].mean() for env in (shown, plain)]
    assert heights[0] > heights[1] + 0.1  # of the head [m]
    shown.close()
    plain.close()
