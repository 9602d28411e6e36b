"""Poses at the right time."""

import numpy as np
import pytest

from adapt_envs import env_id, make_vector
from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.library import load_clip, reference_motion
from adapt_envs.tasks import tracking
from adapt_envs.tasks.tracking import (
    DRIFT_SCALE,
    FREE_DRIFT,
    LOST,
    TRACKING_SCALE,
    GaitClocks,
    GaitCycle,
    PhaseClock,
    tracking_reward,
)
from sb3_adaptnet.algorithms.tracking import guide

STYLES = (
    ["Stoop", "Penguin", "Stomp", "Swaggering", "Sashay", "Limp", "Pace", "Strutting", "Kicking", "Joyful"]
    + ["GooseStep", "JauntySkip"]
)  # fmt: skip
STRUTTING = reference_motion("Strutting")
CYCLE = STRUTTING.poses[..., :3]
PERIOD = len(CYCLE)
PACES = (("Stomp", 0.8), ("Strutting", 1.4))
WORLDS = np.arange(6)
STARTS = WORLDS * PERIOD // len(WORLDS)


def frames(phases):
    """Poses of the cycle, between frames in a straight line."""
    whole = np.floor(phases).astype(int)
    before, after = CYCLE[whole % PERIOD], CYCLE[(whole + 1) % PERIOD]
    return before + (phases - whole)[:, None, None] * (after - before)


def started():
    clock = PhaseClock(CYCLE, STRUTTING.speed, len(WORLDS))
    clock.restart(WORLDS, frames(STARTS))
    return clock


def followed(tempo, speed=1.0):
    """Drift and reward after ten seconds of the clip itself, `tempo` times as quick, at `speed` times its speed."""
    clock, speeds = started(), np.full(len(WORLDS), speed * STRUTTING.speed)
    for step in range(1, 301):
        clock.advance(frames(STARTS + tempo * step), speeds)
    reward = tracking_reward(clock.distances(frames(STARTS + tempo * 300)), clock.drifts)
    return clock.drifts.mean(), reward.mean()


def test_the_reward_is_one_at_the_motion_and_halved_by_either_scale():
    distances, drifts = np.array([0, TRACKING_SCALE, 0, 0]), np.array([FREE_DRIFT, 0, FREE_DRIFT + DRIFT_SCALE, 0])
    assert tracking_reward(distances, drifts) == pytest.approx([1, 0.5, 0.5, 1])
    assert tracking_reward(distances, -drifts) == pytest.approx([1, 0.5, 0.5, 1])


def test_a_clock_starts_at_the_nearest_frame_and_goes_on_with_the_clip():
    clock = started()
    assert (clock.phases == STARTS).all()
    for step in range(1, 2 * PERIOD):
        clock.advance(frames(STARTS + step), np.full(len(WORLDS), STRUTTING.speed))
        assert clock.distances(frames(STARTS + step)) == pytest.approx(0, abs=0.01)
    off = (clock.phases - STARTS + 1 + PERIOD / 2) % PERIOD - PERIOD / 2
    assert off == pytest.approx(0, abs=0.3)


@pytest.mark.parametrize("tempo", [0.5, 0.7, 0.85, 1.0, 1.1, 1.3, 1.6, 2.2])
def test_the_drift_is_how_much_too_quick_the_steps_are(tempo):
    assert followed(tempo)[0] == pytest.approx(tempo - 1, abs=0.02)


@pytest.mark.parametrize("tempo", [0.7, 1.0, 1.4, 1.8])
def test_small_steps_with_a_bent_back_have_their_own_tempo(tempo):
    """Nothing in the cycle looks like them; by the nearest frames nearby steps of 1.8 times the tempo had none."""
    clock, middle = started(), CYCLE.mean(axis=0)
    bent = middle + [0.2, 0.0, -0.1] * (middle[:, 2:] - middle[:, 2:].min())
    drifts = []
    for step in range(1, 601):
        poses = bent + 0.4 * (frames(STARTS + tempo * step) - middle)
        clock.advance(poses.astype(np.float32), np.full(len(WORLDS), STRUTTING.speed))
        drifts.append(clock.drifts)
    assert np.mean(drifts[300:], axis=0) == pytest.approx(tempo - 1, abs=0.03)
    assert np.array(drifts[300:]) == pytest.approx(tempo - 1, abs=0.12)  # P steps are no whole cycles of it


@pytest.mark.parametrize("name", STYLES)
def test_every_style_keeps_its_own_tempo_from_its_first_step(name):
    motion = reference_motion(name)
    cycle = motion.poses[..., :3]
    clock, start = PhaseClock(cycle, motion.speed, 1), len(cycle) // 3
    clock.restart(np.array([0]), cycle[start : start + 1])
    for step in range(start + 1, start + 2 * len(cycle)):
        clock.advance(cycle[[step % len(cycle)]], np.array([motion.speed]))
        assert clock.drifts[0] == pytest.approx(0, abs=0.01)
        assert clock.distances(cycle[[step % len(cycle)]])[0] < 0.02


def test_every_step_towards_the_right_tempo_pays():
    for tempos in ((1.5, 1.35, 1.2, 1.1, 1.0), (0.65, 0.75, 0.9, 1.0)):
        rewards = [followed(tempo)[1] for tempo in tempos]
        assert rewards == sorted(rewards)
        assert rewards[0] < 0.15
        assert rewards[-1] > 0.98


def test_who_is_asked_for_more_speed_may_step_quicker():
    assert followed(np.sqrt(1.2), speed=1.2)[0] == pytest.approx(0, abs=0.01)
    assert followed(np.sqrt(1.2), speed=1.0)[0] == pytest.approx(np.sqrt(1.2) - 1, abs=0.01)
    assert followed(1.3, speed=4.0)[0] == pytest.approx(1.3 / 1.15 - 1, abs=0.01)  # at most 1.15 times as quick


@pytest.mark.parametrize("name", ["TEMPO_EXPONENT", "SLOWEST_TEMPO", "FASTEST_TEMPO"])
def test_both_learners_ask_for_the_same_tempo(name):
    assert getattr(tracking, name) == getattr(guide, name)


def test_a_world_that_is_far_off_is_met_where_it_is():
    clock = started()
    positions = frames(STARTS + 1)
    positions[3] = frames(np.array([PERIOD / 5]))[0] + [0, 0, 1.2 * LOST]
    clock.advance(positions, np.full(len(WORLDS), STRUTTING.speed))
    assert clock.phases[3] == pytest.approx(PERIOD / 5, abs=2)
    assert clock.phases[[0, 1, 2]] == pytest.approx(STARTS[:3] + 1, abs=0.3)


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
        positions = env.pose_windows[:, -1, :, :3]
        clock.advance(positions, env.goal_states.speed)
        assert env.tracking == pytest.approx(tracking_reward(clock.distances(positions), clock.drifts))
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


def test_a_first_reading_after_a_restart_begins_where_the_new_episode_is():
    env, read_always = make_vector(env_id("Stoop"), 8), make_vector(env_id("Stoop"), 8)
    for worlds in (env, read_always):
        worlds.reset(seed=0)
    read_always.tracking  # noqa: B018  # its clocks go from here on
    pose = np.tile(env.single_action_space.mean_pose, (8, 1))
    for _ in range(40):
        _, _, terminated, truncated, _ = env.step(pose)
        read_always.step(pose)
        if (ended := terminated | truncated).any():
            break
    assert ended.any()
    env.tracking, read_always.tracking  # noqa: B018
    env.step(pose)
    read_always.step(pose)
    assert env.tracking[ended] == pytest.approx(read_always.tracking[ended])


def test_at_the_target_it_stays_as_it_was_on_arrival():
    env = make_vector(env_id("Stoop"), 4)
    env.reset(seed=0)
    arrived = env.tracking
    pose = np.tile(env.single_action_space.mean_pose, (4, 1))
    for _ in range(6):
        env.worlds.goals.target[:2] = env.worlds.root_xy[:2]
        env.step(pose)
    assert np.array_equal(env.tracking[:2], arrived[:2]) and (env.tracking[2:] < 0.9).all()
    env.worlds.goals.target[:2] += 3
    env.step(pose)
    assert (env.tracking < 0.9).all()  # where there is way to go again it is what the world does


def test_a_motion_of_minutes_is_followed_by_its_gaits():
    env = make_vector(env_id("Walk"), 64)
    env.reset(seed=0)
    assert env.tracking.mean() > 0.7  # start states are the motion's, turns and all
    pose = np.tile(env.single_action_space.mean_pose, (64, 1))
    for _ in range(20):
        env.step(pose)
    assert 0 < env.tracking.mean() < 0.4


@pytest.mark.parametrize(("asked", "counts"), [(0.5, 0), (0.9, 0), (1.4, 1), (3.0, 1)])
def test_the_cycle_nearest_to_the_preferred_speed_counts(asked, counts):
    cycles = [GaitCycle(reference_motion(name).poses[..., :3], speed) for name, speed in PACES]
    positions, speeds = cycles[1].positions[:5], np.full(4, asked)
    rewards = []
    for followed in (cycles, cycles[:1], cycles[1:]):
        clocks = GaitClocks(followed, 4)
        clocks.restart(np.arange(4), positions[:4])
        clocks.advance(positions[1:], speeds)
        rewards.append(clocks.rewards(positions[1:], speeds))
    assert (rewards[0] == rewards[1 + counts]).all() and (rewards[0] != rewards[2 - counts]).all()


def test_who_is_asked_for_another_speed_is_met_where_it_is_in_the_other_cycle():
    cycles = [GaitCycle(reference_motion(name).poses[..., :3], speed) for name, speed in PACES]
    clocks, slow, fast = GaitClocks(cycles, 1), *(cycle.positions for cycle in cycles)
    clocks.restart(np.array([0]), slow[:1])
    for step in range(1, 8):
        clocks.advance(slow[[step % len(slow)]], np.array([PACES[0][1]]))
    frame = len(fast) // 2
    for step in range(frame, frame + 2 * len(fast)):
        pose, speed = fast[[step % len(fast)]], np.array([PACES[1][1]])
        clocks.advance(pose, speed)
        if step == frame:  # at once, by the nearest frame, whatever the clock showed before
            assert clocks._clocks[1].distances(pose)[0] == pytest.approx(0, abs=1e-3)
    assert clocks.rewards(pose, speed)[0] > 0.95


def test_without_a_gait_there_is_nothing_to_follow(tmp_path):
    clip = load_clip("walk")
    file = tmp_path / "pause.npz"
    MotionClip("pause", np.repeat(clip.qpos[:1], 90, axis=0), clip.joint_names).save(file)
    env = make_vector(env_id("Style"), 2, motion=str(file), speed_range=(1.0, 1.5))
    env.reset(seed=0)
    with pytest.raises(MotionError, match="'pause' holds no gait cycle at 1.00, 1.14, 1.31, 1.50 m/s"):
        _ = env.tracking


def test_longer_legs_have_the_cycle_that_they_show():
    env = make_vector(env_id("LongThighsWalk"), 2, motion="Stoop", clip_on_body=True)
    plain = make_vector(env_id("Stoop"), 2)
    reference = env.worlds.reference
    assert reference.speed > plain.worlds.reference.speed
    assert len(reference.poses) > len(plain.worlds.reference.poses)
