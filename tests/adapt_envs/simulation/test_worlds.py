"""Goals, restarts and failures of worlds."""

import mujoco
import numpy as np
import pytest

from adapt_envs import env_id, make_vector
from adapt_envs.features import rotations
from adapt_envs.motion.library import load_clip
from adapt_envs.suite import SUITE, preferred_speeds
from adapt_envs.tasks.goal import goal_observation, goal_reward, targets_ahead
from adapt_envs.tasks.termination import DIVERGED, ENDS, FALL, LOST, TIME, ends


def test_goal_reward_by_hand():
    before = np.zeros((4, 2))
    target = np.array([[4.0, 0], [4.0, 0], [0.0, 3.0], [0.4, 0]])
    # Exactly the wanted velocity; standing still; half the speed at right angles; inside the radius.
    after = np.array([[1.2 / 30, 0], [0, 0], [0.5 / 30, 0], [0, 0]])
    speed = np.array([1.2, 1.5, 1.0, 1.0])
    expected = [1, np.exp(-3), np.exp(-3 * (0.25 + 1)), 1]
    assert np.allclose(goal_reward(before, after, target, speed), expected, rtol=1e-12)


def test_goal_observation_by_hand():
    root = np.array([[1.0, 2.0], [0.0, 0.0]])
    heading = np.array([np.pi / 2, 0.3])
    target = np.array([[1.0, 5.0], [0.003, 0.004]])
    seen = goal_observation(root, heading, target, np.array([1.1, 1.3]))
    # Straight ahead of a root that faces y; and nearer than 1 cm, where the direction is zero.
    assert np.allclose(seen, [[1, 0, 3, 1.1], [0, 0, 0.005, 1.3]], atol=1e-6)


def test_targets_lie_as_far_as_one_gets():
    target = targets_ahead(np.array([[1.0, 1.0]]), np.array([np.pi / 2]), np.array([1.2]), np.array([4.0]))
    assert np.allclose(target, [[1, 5.8]])


def test_the_worst_end_wins():
    yes, no = np.array([True]), np.array([False])
    cases = {"time": (no, no, no), "lost": (no, yes, no), "fall": (yes, yes, no), "diverged": (yes, yes, yes)}
    for name, (fallen, lost, diverged) in cases.items():
        assert ENDS[ends(fallen, lost, diverged, yes)[0]] == name
    assert [ENDS.index(name) for name in cases] == [TIME, LOST, FALL, DIVERGED]


def test_speed_range_follows_a_slow_clip():
    for name, spec in SUITE.items():
        clip = load_clip(spec.motion)
        low, high = preferred_speeds(spec, clip)
        assert 0 < low < high
        if name not in ("Walk", "Run"):
            assert low <= clip.mean_speed <= high, name


@pytest.mark.parametrize("asked", [1.0, 0.15])
def test_contact_friction_is_as_asked(asked):
    worlds = make_vector(env_id("Walk"), 1, friction=asked).worlds
    worlds.reset(np.arange(1))
    data = mujoco.MjData(worlds.model)
    floor, touching = worlds.model.geom("floor").id, []
    for _ in range(30):
        worlds.step(worlds.reference.mean_pose[None], None)
        worlds.physics.mujoco_data(0, data)
        touching += [contact.friction[0] for contact in data.contact if floor in contact.geom]
    assert touching
    assert np.allclose(touching, asked)


def test_blocks_are_as_slippery_as_the_ground():
    model = make_vector(env_id("Obstacles"), 1, friction=0.15).worlds.model
    blocks = [geom for geom in map(model.geom, range(model.ngeom)) if geom.name.startswith("obstacle_")]
    foot = next(geom for geom in map(model.geom, range(model.ngeom)) if geom.priority[0] == 0)
    assert blocks and all(block.friction[0] == 0.15 and block.priority[0] > foot.priority[0] for block in blocks)


def test_goals_are_redrawn_when_the_timer_ends_and_not_before():
    env = make_vector(env_id("Walk"), 32)
    env.reset(seed=0)
    goals = env.worlds.goals
    pose = np.tile(env.single_action_space.mean_pose, (32, 1))
    for _ in range(100):
        before, left = goals.target.copy(), goals.steps_left.copy()
        *_, infos = env.step(pose)
        restarted = infos.get("_final_obs", np.zeros(32, bool))
        changed = (goals.target != before).any(axis=1)
        assert np.array_equal(changed, (left <= 1) | restarted)
        assert (goals.steps_left >= 1).all()
        assert (goals.steps_left <= 150).all()


def test_goals_come_from_a_share_of_the_circle_ahead():
    env = make_vector(env_id("Run"), 256)
    env.goal_spread = 0.25
    env.reset(seed=0)
    assert (env.goal_spread == 0.25).all()
    worlds = env.worlds
    offset = worlds.goals.target - worlds.root_xy
    off_ahead = rotations.wrapped(np.arctan2(offset[:, 1], offset[:, 0]) - worlds.root_heading)
    assert np.abs(off_ahead).max() == pytest.approx(np.pi / 4, abs=0.05)
    assert np.abs(off_ahead.mean()) < 0.1
    with pytest.raises(ValueError, match=r"1\.5"):
        env.goal_spread = 1.5
    assert (env.goal_spread == 0.25).all()


def test_a_held_goal_stays_ahead():
    env = make_vector(env_id("Walk"), 4)
    env.reset(seed=0)
    env.set_goal(heading=1.0, speed=1.2)
    for _ in range(10):
        env.step(np.tile(env.single_action_space.mean_pose, (4, 1)))
        worlds = env.worlds
        offset = worlds.goals.target - worlds.root_xy
        assert np.allclose(np.arctan2(offset[:, 1], offset[:, 0]), 1.0, atol=1e-4)
        assert np.allclose(np.linalg.norm(offset, axis=1), 6.0, atol=1e-4)
        assert np.allclose(worlds.goals.speed, 1.2)
    env.set_goal(None, None)
    assert len(np.unique(env.worlds.goals.speed)) == 4


def test_a_diverged_world_ends_alone_with_its_last_finite_observation():
    env = make_vector(env_id("Walk"), 6)
    observations, _ = env.reset(seed=0)
    pose = np.tile(env.single_action_space.mean_pose, (6, 1))
    observations, *_ = env.step(pose)
    env.worlds.physics.qvel[2, 8] = 1e12
    env.worlds.physics.qpos[4, 9] = np.nan
    after, rewards, terminated, _, infos = env.step(pose)
    assert infos["final_info"]["end"][2] == infos["final_info"]["end"][4] == "diverged"
    assert (infos["final_info"]["diverged_worlds"] == env.diverged_worlds).all() and env.diverged_worlds == 2
    for world in (2, 4):
        assert terminated[world]
        assert np.array_equal(infos["final_obs"][world], observations[world])
        assert rewards[world] == 0
    assert np.isfinite(after).all()
    assert np.isfinite(env.pose_windows).all()
    assert env.step(pose)[4] == {}, "the restarted worlds are sound again"
    env.worlds.physics.qvel[2, 8] = 1e12
    assert env.step(pose)[4]["final_info"]["end"][2] == "diverged"
    assert env.diverged_worlds == 3
    alone = make_vector(env_id("Walk"), 6)
    alone.reset(seed=0)
    alone.step(pose)
    untouched = alone.step(pose)[0]
    assert np.array_equal(after[[0, 1, 3, 5]], untouched[[0, 1, 3, 5]])


def test_what_a_step_returned_outlives_a_reset():
    env = make_vector(env_id("Walk"), 3)
    env.reset(seed=0)
    observations, *_ = env.step(np.tile(env.single_action_space.mean_pose, (3, 1)))
    kept = observations.copy()
    env.reset(seed=5)
    assert np.array_equal(observations, kept)


def test_stagger_spreads_the_first_time_limits():
    env = make_vector(env_id("Walk"), 256, stagger=True)
    for _ in range(2):
        env.reset(seed=0)
        assert env.worlds.steps.std() > 60
        assert env.worlds.steps.max() < 300
    plain = make_vector(env_id("Walk"), 8)
    plain.reset(seed=0)
    assert (plain.worlds.steps == 0).all()
