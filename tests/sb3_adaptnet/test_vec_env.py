"""AdaptVecEnv hands on what the gymnasium vector environment says, in Stable-Baselines3's words."""

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers import ClipReward
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecMonitor
from toy_env import ToyVectorEnv

from sb3_adaptnet import AdaptVecEnv
from sb3_adaptnet.objectives.attribute_ramp import set_in_worlds
from sb3_adaptnet.objectives.pose_windows import pose_windows, reference_windows
from sb3_adaptnet.zoo import ZooVecEnv

WALK, PUSHES = "AdaptNet/Humanoid-Walk-v0", "AdaptNet/Humanoid-PushWalk-v0"


def actions(env, rng):
    return rng.uniform(-1, 1, (env.num_envs, *env.action_space.shape)).astype(np.float32)


@pytest.mark.parametrize("make", [
    lambda: ToyVectorEnv(6),
    lambda: ToyVectorEnv(6, heightmap=True),
    lambda: gym.make_vec(WALK, 6, vectorization_mode="vector_entry_point", max_episode_steps=12),
], ids=["toy", "dict", "walk"])  # fmt: skip
def test_equals_the_vector_environment(make):
    """Same seed and actions, step by step: observations, rewards, ends, final observations, windows."""
    ours, theirs, rng = AdaptVecEnv(make()), make(), np.random.default_rng(0)
    ours.seed(7)
    ours_obs, (theirs_obs, _) = ours.reset(), theirs.reset(seed=7)
    finished, returns = 0, np.zeros(6)
    for _ in range(60):
        same(ours_obs, theirs_obs)
        chosen = actions(ours, rng)
        ours_obs, rewards, dones, infos = ours.step(chosen)
        theirs_obs, theirs_rewards, terminated, truncated, theirs_infos = theirs.step(chosen)
        np.testing.assert_allclose(rewards, theirs_rewards, rtol=1e-6)
        np.testing.assert_array_equal(dones, terminated | truncated)
        np.testing.assert_array_equal(ours.pose_windows, theirs.pose_windows)
        returns += theirs_rewards
        for world in np.flatnonzero(dones):
            same(infos[world]["terminal_observation"], theirs_infos["final_obs"][world])
            assert infos[world]["TimeLimit.truncated"] == truncated[world]
            assert (infos[world]["end"] == "time") == truncated[world]
            assert infos[world]["episode"]["r"] == pytest.approx(returns[world], abs=1e-4)
            returns[world], finished = 0.0, finished + 1
        assert all(not infos[world] for world in np.flatnonzero(~dones))
    assert finished > 0
    ours.close()
    theirs.close()


def same(ours, theirs):
    pairs = [(ours[key], theirs[key]) for key in theirs] if isinstance(theirs, dict) else [(ours, theirs)]
    for a, b in pairs:
        np.testing.assert_array_equal(a, b)


def test_episodes_are_reported_as_by_vec_monitor():
    env, rng = VecMonitor(AdaptVecEnv(ToyVectorEnv(5))), np.random.default_rng(0)
    env.seed(1)
    env.reset()
    seen = 0
    for _ in range(60):
        inner = env.venv.step(chosen := actions(env, rng))
        del chosen
        env.venv.step_wait = lambda result=inner: result
        _, _, dones, infos = env.step_wait()
        del env.venv.step_wait
        for world in np.flatnonzero(dones):
            own, monitors = inner[3][world]["episode"], infos[world]["episode"]
            assert own["l"] == monitors["l"] and own["r"] == pytest.approx(monitors["r"], abs=1e-4)
            seen += 1
    assert seen > 0


def test_observations_are_never_written_again():
    env, rng = AdaptVecEnv(ToyVectorEnv(4)), np.random.default_rng(0)
    first = env.reset()
    kept = first.copy()
    for _ in range(3):
        env.step(actions(env, rng))
    np.testing.assert_array_equal(first, kept)


def test_windows_through_every_door():
    env = AdaptVecEnv(ToyVectorEnv(4))
    env.reset()
    assert pose_windows(env).shape == (4, 5, 15, 7)
    assert len(env.get_attr("pose_windows")) == 4 and env.get_attr("pose_windows")[0].shape == (5, 15, 7)
    first, second = (reference_windows(env, 9, np.random.default_rng(0)) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    rng = np.random.default_rng(0)
    assert not np.array_equal(reference_windows(env, 9, rng), reference_windows(env, 9, rng))
    assert env.env_is_wrapped(Monitor) == [True] * 4 and env.env_is_wrapped(gym.wrappers.TimeLimit) == [False] * 4
    assert env.env_method("sample_reference_windows", 3, rng, indices=[0])[0].shape == (3, 5, 15, 7)
    with pytest.raises(ValueError, match="all 4 worlds"):
        env.set_attr("drift", 0.2, indices=[1])
    with pytest.raises(AttributeError, match="no attribute 'drifft'"):
        env.set_attr("drifft", 0.2)


def test_ramps_reach_worlds_behind_wrappers():
    for env in (DummyVecEnv([lambda: gym.make(PUSHES)]), AdaptVecEnv(PUSHES, num_envs=2, num_threads=1)):
        set_in_worlds(env, "push_scale", 0.25)
        assert env.get_attr("push_scale")[0] == 0.25
        worlds = env.envs[0].unwrapped if isinstance(env, DummyVecEnv) else env.vector_env.unwrapped
        assert (worlds.worlds.pushes.scale == 0.25).all()
        set_in_worlds(env, "push_scale", np.array([0.5, 0.25])[: env.num_envs])
        assert worlds.worlds.pushes.scale.tolist() == [0.5, 0.25][: env.num_envs]
        env.close()


def test_from_an_id_a_spec_and_zoos_functions():
    envs = [
        AdaptVecEnv(WALK, num_envs=3, num_threads=1),
        AdaptVecEnv(gym.spec(WALK), num_envs=3, num_threads=1),
        ZooVecEnv([lambda: gym.make(WALK)] * 3, num_threads=1),
    ]
    for env in envs:
        assert env.num_envs == 3 and env.reset().shape == (3, 784)
        assert env.action_space.default_base == "walk" and len(env.action_space.joint_names) == 28
        env.close()


def test_a_specs_time_limit_holds():
    def make():
        return gym.make(WALK, max_episode_steps=5)

    for env in (AdaptVecEnv(make().spec, num_envs=1, num_threads=1), ZooVecEnv([make], num_threads=1)):
        env.reset()
        pose = env.action_space.mean_pose[None]
        ends = [bool(env.step(pose)[2][0]) for _ in range(5)]
        assert ends == [False] * 4 + [True]
        env.close()


def test_wrappers_of_ones_own_are_refused_where_they_would_be_lost():
    with pytest.raises(ValueError, match="no wrappers of their own, as ClipReward is one"):
        ZooVecEnv([lambda: ClipReward(gym.make(WALK), -1, 1)] * 2)


def test_options_are_those_of_all_worlds():
    env = AdaptVecEnv(WALK, num_envs=2, num_threads=1)
    env.set_options([{"goal_heading": 0.0, "goal_speed": 1.0}, {"goal_heading": 0.0, "goal_speed": 1.4}])
    with pytest.raises(ValueError, match="all worlds are reset by the same options"):
        env.reset()


def test_same_seed_same_rollout():
    rollouts = []
    for _ in range(2):
        env, rng = AdaptVecEnv(WALK, num_envs=4, num_threads=1, seed=5), np.random.default_rng(0)
        rows = [env.reset()] + [env.step(actions(env, rng))[0] for _ in range(5)]
        rollouts.append(np.stack(rows))
        env.close()
    np.testing.assert_array_equal(*rollouts)


def test_worlds_that_restart_one_step_later_are_refused():
    with pytest.raises(ValueError, match="NEXT_STEP, where .*SAME_STEP is needed"):
        AdaptVecEnv(gym.make_vec("CartPole-v1", 4))
