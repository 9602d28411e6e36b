"""One suite for every row of the table."""

import pickle

import gymnasium as gym
import numpy as np
import pytest
import stable_baselines3.common.env_checker as sb3_checker
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers.vector import DictInfoToList

from adapt_envs import SUITE, AdaptEnv, AdaptVectorEnv, env_id, make_vector
from adapt_envs.spaces import JointSpace
from adapt_envs.tasks.termination import ENDS

LOOKS = {
    (row.morphology, row.locked, row.terrain, row.terrain_scale, row.obstacles, row.push is None): name
    for name, row in SUITE.items()
}
"""A row of each body on each ground; of styles one, since they differ in their motions alone."""
each_look = pytest.mark.parametrize("name", [env_id(name) for name in LOOKS.values()])
# One row after the other: what a process keeps of characters and motions does not suffice for all rows in turn.
each_row = pytest.mark.parametrize("name", [env_id(name) for name in SUITE], scope="module")


def equal(a, b):
    """Equality of observations, which may be dictionaries."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(np.array_equal(a[key], b[key]) for key in a)
    return np.array_equal(a, b)


def rollout(env, seed, steps=12):
    """Observations, rewards and ends of seeded random actions near the mean pose."""
    rng = np.random.default_rng(seed)
    trace = [env.reset(seed=seed)[0]]
    rewards = []
    for _ in range(steps):
        pose = env.action_space.mean_pose + 0.05 * rng.standard_normal(env.action_space.shape)
        observation, reward, terminated, truncated, _ = env.step(pose.astype(np.float32))
        trace.append(observation)
        rewards.append(reward)
        if terminated or truncated:
            trace.append(env.reset()[0])
    return trace, rewards


@pytest.mark.filterwarnings("ignore::UserWarning")
@each_look
def test_both_checkers_accept_it(name):
    env = gym.make(name)
    check_env(env.unwrapped, skip_render_check=True)
    sb3_checker.check_env(env)


@each_row
def test_same_seed_same_rollout(name):
    first, second = (rollout(gym.make(name), seed=3) for _ in range(2))
    assert all(equal(a, b) for a, b in zip(first[0], second[0], strict=True))
    assert first[1] == second[1]
    assert not equal(first[0][0], rollout(gym.make(name), seed=4, steps=1)[0][0])


@each_row
def test_a_vector_of_one_equals_the_single_env(name):
    single, vector = gym.make(name).unwrapped, make_vector(name, 1)
    a, b = single.reset(seed=5)[0], vector.reset(seed=5)[0]
    rng = np.random.default_rng(5)
    for _ in range(20):
        row = {key: value[0] for key, value in b.items()} if isinstance(b, dict) else b[0]
        assert equal(a, row)
        action = (single.action_space.mean_pose + 0.05 * rng.standard_normal(single.action_space.shape)).astype("f4")
        a, reward, terminated, truncated, info = single.step(action)
        b, rewards, terminations, truncations, infos = vector.step(action[None])
        assert (reward, terminated, truncated) == (rewards[0], terminations[0], truncations[0])
        if terminated or truncated:
            assert equal(a, infos["final_obs"][0])
            assert info["end"] == infos["final_info"]["end"][0]
            break


@each_row
def test_spec_rebuilds_it_and_pickles(name):
    env = gym.make(name)
    again = gym.make(pickle.loads(pickle.dumps(env.spec)))
    assert again.observation_space == env.observation_space
    assert again.action_space == env.action_space
    space = pickle.loads(pickle.dumps(env.action_space))
    assert isinstance(space, JointSpace)
    assert space == env.action_space
    assert space.default_base == env.action_space.default_base
    assert np.array_equal(space.mean_pose, env.action_space.mean_pose)
    assert all(equal(a, b) for a, b in zip(rollout(env, 6, 3)[0], rollout(again, 6, 3)[0], strict=True))


@each_look
def test_it_renders(name):
    env = gym.make(name, render_mode="rgb_array")
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (480, 640, 3)
    assert picture.std() > 5, "the picture is blank"
    env.close()


@each_row
def test_windows_of_world_and_reference_have_one_layout(name):
    env = make_vector(name, 8)
    env.reset(seed=0)
    env.step(np.tile(env.single_action_space.mean_pose, (8, 1)))
    reference = env.sample_reference_windows(64, np.random.default_rng(0))
    assert env.pose_windows.shape == (8, 5, 15, 7)
    assert reference.shape == (64, 5, 15, 7)
    for windows in (env.pose_windows, reference):
        assert windows.dtype == np.float32
        assert np.allclose(np.linalg.norm(windows[..., 3:], axis=-1), 1, atol=1e-3)
        assert np.abs(windows[:, -1, 0, :2]).max() < 1e-5, "the last root stands over the origin"
        assert (windows[..., 3] >= 0).all()


@pytest.mark.parametrize("steps", [None, 0, -1])
def test_no_time_limit(steps):
    env = make_vector(env_id("Walk"), 2, max_episode_steps=steps, stagger=True)
    env.reset(seed=0)
    assert not env.step(np.tile(env.single_action_space.mean_pose, (2, 1)))[3].any()


def test_a_seed_means_the_same_episodes_whatever_was_asked_for_before():
    env, fresh = make_vector(env_id("Walk"), 2), make_vector(env_id("Walk"), 2)
    env.reset(seed=0, options={"goal_heading": 0.0, "goal_speed": 1.0})
    assert (env.worlds.goals.held_heading == 0).all()
    assert equal(env.reset(seed=3)[0], fresh.reset(seed=3)[0])
    env.set_goal(1.0, 1.2)
    env.reset(seed=3)
    assert (env.worlds.goals.held_heading == 1.0).all()  # what `set_goal` holds stays
    env.reset(options={"goal_heading": None, "goal_speed": None})
    assert np.isnan(env.worlds.goals.held_heading).all()


def test_a_seed_means_the_same_episodes_on_bounded_ground_too():
    """Where targets are drawn again until they are free, as often as the place asks for."""
    env, found = make_vector(env_id("Obstacles"), 4), []
    for _ in range(3):
        found.append(env.reset(seed=3, options={"goal_heading": None, "goal_speed": None})[0])
        for _ in range(20):
            env.step(np.tile(env.single_action_space.mean_pose, (4, 1)))
    assert equal(found[0], found[1]) and equal(found[0], found[2])


def test_worlds_that_were_never_reset_do_not_step():
    env = make_vector(env_id("Walk"), 2)
    with pytest.raises(ValueError, match="never reset cannot step: call reset"):
        env.step(np.tile(env.single_action_space.mean_pose, (2, 1)))


@pytest.mark.parametrize(
    ("worlds", "threads", "words"),
    [(0, 1, "number of worlds .* 0"), (2.5, 1, "not 2.5"), ("3", 1, "not '3'"), (2, 1.5, "num_threads .* 1.5")],
)
def test_worlds_and_threads_are_whole_numbers(worlds, threads, words):
    with pytest.raises(ValueError, match=words):
        AdaptVectorEnv("Walk", worlds, num_threads=threads)


def test_what_a_reset_asked_for_holds_over_what_set_goal_holds_until_the_next_one():
    env = make_vector(env_id("Walk"), 3)
    goals = env.worlds.goals
    env.reset(seed=0, options={"goal_heading": 0.5, "goal_speed": 1.2})
    env.set_goal(1.0, 1.1, np.array([0]))
    env.reset(seed=0)
    assert np.array_equal(goals.held_heading, [1.0, np.nan, np.nan], equal_nan=True)
    env.reset(options={"goal_heading": 0.5, "goal_speed": 1.2})
    assert (goals.held_heading == 0.5).all() and (goals.held_speed == 1.2).all()
    env.reset()
    assert np.array_equal(goals.held_heading, [1.0, np.nan, np.nan], equal_nan=True)
    assert goals.held_speed[0] == 1.1


def test_what_a_vector_says_of_ends_is_gymnasiums_form():
    env = DictInfoToList(make_vector(env_id("Walk"), 2, max_episode_steps=2))
    env.reset(seed=0)
    actions = np.tile(env.unwrapped.single_action_space.mean_pose, (2, 1))
    env.step(actions)
    infos = env.step(actions)[4]
    assert [info["final_info"] for info in infos] == [{"end": "time", "diverged_worlds": 0}] * 2


def test_what_was_returned_stays_as_it_was():
    env = make_vector(env_id("Walk"), 2)
    env.reset(seed=0)
    actions = np.tile(env.single_action_space.mean_pose, (2, 1))
    observations = env.step(actions)[0]
    kept = observations.copy()
    env.restart(np.array([0]))
    assert equal(observations, kept)
    observations[:] = 7  # as one would who normalises in place
    env.worlds.physics.qpos[1, 9] = np.nan
    final = env.step(actions)[4]["final_obs"][1]
    assert equal(final, kept[1])


def test_a_seed_for_each_world_is_the_first_ones():
    env = make_vector(env_id("Walk"), 2)
    assert equal(env.reset(seed=[5, 6])[0], env.reset(seed=5)[0])
    env.reset(seed=[])


def test_every_episode_end_is_named_and_reachable():
    seen = set()
    env = make_vector(env_id("Walk"), 64, max_episode_steps=40)
    env.reset(seed=0, options={"goal_heading": 0.0, "goal_speed": 1.2})
    rng = np.random.default_rng(0)
    for step in range(120):
        noise = 0.5 if step > 60 else 0.02
        actions = env.single_action_space.mean_pose + noise * rng.standard_normal((64, 28))
        _, _, terminated, truncated, infos = env.step(actions.astype(np.float32))
        if infos:
            named = infos["final_info"]["end"]
            assert np.array_equal(infos["final_info"]["_end"], terminated | truncated)
            seen |= {end for end in named if end}
            assert all(named[i] == "time" for i in np.flatnonzero(truncated))
    assert {"fall", "time"} <= seen <= set(ENDS)


def test_reset_refuses_unknown_options_and_starts():
    env = AdaptEnv("Walk")
    with pytest.raises(ValueError, match="unknown reset option 'goal'; the options are goal_heading"):
        env.reset(options={"goal": 1})
    with pytest.raises(ValueError, match="start state -1 does not exist"):
        env.reset(options={"start": -1, "goal_heading": 1.0, "goal_speed": 1.0})
    with pytest.raises(ValueError, match=r"by heading and speed together, not by 1\.0 and None"):
        env.reset(options={"goal_heading": 1.0})
    for heading, speed in ((np.nan, 1.0), (0.0, 0.0), (0.0, np.inf)):
        with pytest.raises(ValueError, match="heading must be finite and its speed positive"):
            env.set_goal(heading, speed)
    assert np.isnan(env.worlds.goals.held_heading).all()  # nothing was held by what was refused


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"task": "Wlak"}, "no environment is named 'Wlak'; the names are Walk, Run"),
        ({"task": "Walk", "render_mode": "ascii"}, "render_mode 'ascii' is unknown; the modes are rgb_array"),
        ({"task": "Walk", "speed": 1}, "unknown argument 'speed'; the arguments are motion"),
        ({"task": "Walk", "speed_range": (2, 1)}, "expected 0 < low <= high"),
        ({"task": "Style", "motion": "Moonwalk"}, "no motion named 'Moonwalk'; names are walk, run"),
    ],
)
def test_bad_arguments_get_one_sentence(arguments, message):
    with pytest.raises(ValueError, match=message):
        AdaptEnv(**arguments)
