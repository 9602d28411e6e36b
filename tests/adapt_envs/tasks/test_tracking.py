"""Poses at the right time."""

import numpy as np
import pytest

from adapt_envs import env_id, make_vector
from adapt_envs.motion.library import reference_motion
from adapt_envs.tasks.tracking import LOST, MOST_DRIFT, TRACKING_SCALE, PhaseClock, tracking_reward

STRUTTING = reference_motion("Strutting")
CYCLE = STRUTTING.poses[..., :3]
PERIOD = len(CYCLE)
WORLDS = np.arange(6)
STARTS = WORLDS * PERIOD // len(WORLDS)


def frames(phases):
    return CYCLE[np.rint(phases).astype(int) % PERIOD]


def rewards_at(tempo, speed=1.0, steps=300):
    """Mean reward of the clip itself, `tempo` times as quick, where `speed` times its speed is asked for."""
    clock = PhaseClock(CYCLE, STRUTTING.speed, len(WORLDS))
    clock.restart(WORLDS, frames(STARTS))
    speeds = np.full(len(WORLDS), speed * STRUTTING.speed)
    steps = range(1, steps + 1)
    return np.mean([tracking_reward(clock.advance(frames(STARTS + tempo * step), speeds)) for step in steps])


def test_the_reward_is_one_at_the_motion_and_falls_with_the_distance():
    assert tracking_reward(np.array([0, TRACKING_SCALE, 2 * TRACKING_SCALE])) == pytest.approx([1, 1 / np.e, np.e**-4])


def test_a_clock_starts_at_the_nearest_frame_and_goes_on_with_the_clip():
    clock = PhaseClock(CYCLE, STRUTTING.speed, len(WORLDS))
    clock.restart(WORLDS, frames(STARTS))
    assert (clock.phases == STARTS).all()
    for step in range(1, 2 * PERIOD):
        assert clock.advance(frames(STARTS + step), np.full(len(WORLDS), STRUTTING.speed)) == pytest.approx(0)
    assert (clock.phases == (STARTS + 2 * PERIOD - 1) % PERIOD).all()


def test_the_clip_too_quick_or_too_slow_is_worth_half_as_much():
    assert rewards_at(1.0) > 0.95
    assert rewards_at(1.0 + 0.8 * MOST_DRIFT) > 0.9
    assert rewards_at(1.25) < 0.55
    assert rewards_at(0.8) < 0.55


def test_who_is_asked_for_more_speed_may_step_quicker():
    assert rewards_at(np.sqrt(1.2), speed=1.2) > 0.9
    assert rewards_at(np.sqrt(1.2), speed=1.0) < 0.6
    assert rewards_at(1.3, speed=4.0) < 0.6  # no quicker than 1.15 times


def test_a_world_that_is_far_off_is_met_where_it_is():
    clock = PhaseClock(CYCLE, STRUTTING.speed, 2)
    clock.restart(np.arange(2), frames(np.zeros(2)))
    fallen = frames(np.array([1.0, PERIOD / 2]))
    fallen[1] += 2 * LOST
    before = clock.advance(fallen, np.full(2, STRUTTING.speed))
    assert before[1] > LOST
    assert abs(clock.phases[1] - PERIOD / 2) < PERIOD / 4
    assert clock.phases[0] == pytest.approx(1)


def test_environments_follow_the_motion_step_by_step():
    env = make_vector(env_id("Stoop"), 4)
    env.reset(seed=0)
    assert env.tracking == pytest.approx(np.ones(4), abs=1e-3)  # followed from here on
    positions = env.pose_windows[:, -1, :, :3]
    clock = PhaseClock(env.worlds.reference.poses[..., :3], env.worlds.reference.speed, 4)
    clock.restart(np.arange(4), positions)
    pose = np.tile(env.single_action_space.mean_pose, (4, 1))
    for _ in range(8):
        env.step(pose)
        speeds = env.goal_states.speed
        assert env.tracking == pytest.approx(tracking_reward(clock.advance(env.pose_windows[:, -1, :, :3], speeds)))
    assert 0.1 < env.tracking.mean() < 0.9


def test_environments_keep_it_for_the_transition_before_a_restart():
    env = make_vector(env_id("Stoop"), 16)
    env.reset(seed=0)
    assert env.tracking == pytest.approx(np.ones(16), abs=1e-3)  # start states are the motion's
    pose = np.tile(env.single_action_space.mean_pose, (16, 1))
    for _ in range(60):
        _, _, terminated, truncated, _ = env.step(pose)
        assert ((env.tracking >= 0) & (env.tracking <= 1)).all()
        if (terminated | truncated).any():
            break
    fallen = terminated | truncated
    assert fallen.any()
    assert env.tracking[fallen].max() < 0.2  # the fall's, and not the start state's that the world is in now
    env.step(pose)
    assert env.tracking[fallen].min() > 0.5


def test_a_motion_that_does_not_repeat_has_none():
    env = make_vector(env_id("Walk"), 2)
    env.reset(seed=0)
    assert (env.tracking == 0).all()


def test_longer_legs_have_the_cycle_that_they_show():
    env = make_vector(env_id("LongThighsWalk"), 2, motion="Stoop", clip_on_body=True)
    plain = make_vector(env_id("Stoop"), 2)
    reference = env.worlds.reference
    assert reference.speed > plain.worlds.reference.speed
    assert len(reference.poses) > len(plain.worlds.reference.poses)
