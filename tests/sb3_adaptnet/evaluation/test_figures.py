"""The figures of motions whose figures are known."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from evaluation_cases import STOOP, recording_of, save_tiny_base

from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.motion.clip import FPS, MotionError, transformed
from adapt_envs.motion.library import load_clip
from adapt_envs.motion.quality import check
from sb3_adaptnet import load_policy
from sb3_adaptnet.evaluation.alpha import record_base
from sb3_adaptnet.evaluation.figures import evaluate, figures_of
from sb3_adaptnet.evaluation.imitation_error import (
    Reference,
    frame_errors,
    imitation_error,
    local_positions,
    matches,
)
from sb3_adaptnet.evaluation.recording import _Targets, open_worlds, record, record_straight, reference_speed
from sb3_adaptnet.evaluation.rollout_clips import clip_of, longest, typical_clip
from sb3_adaptnet.evaluation.smoothness import clip_jerk, jerk_ratio, mean_jerk, slips


class Flail:
    """Throws itself about: the same action for ever, which fells the character within a second or two."""

    def predict(self, observation, state=None, episode_start=None, deterministic=False):
        assert deterministic
        return np.full((len(observation), 28), 0.4, np.float32), None


@pytest.fixture(scope="module")
def stoop():
    return load_clip("Stoop")


@pytest.fixture(scope="module")
def four():
    return open_worlds(STOOP, 4, num_threads=1)


# ---- imitation error ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speeds", [[1], [2], [1, 2], [1, 0]], ids=["same", "double", "1.5", "half"])
def test_the_clip_played_back_anywhere_at_any_speed_has_no_error(stoop, speeds):
    frames = 5 + np.concatenate([[0], np.cumsum(np.resize(speeds, 300))])
    motion = transformed(stoop.at(frames), 2.1, np.array([3.0, -4.0]))
    found = imitation_error(recording_of(motion), stoop)
    assert found.frames == 301 - 60
    assert found.mean == pytest.approx(0, abs=2e-5) and found.std == pytest.approx(0, abs=2e-5)


def test_the_error_is_the_mean_distance_over_the_links(stoop):
    reference = Reference.of(stoop).positions
    moved = reference + np.array([0.03, 0, 0.04], np.float32)
    assert np.diag(frame_errors(moved, reference)) == pytest.approx(0.05, abs=1e-6)
    one_link = reference.copy()
    one_link[:, 7, 1] += 0.3
    assert np.diag(frame_errors(one_link, reference)) == pytest.approx(0.3 / 15, abs=1e-6)


def test_the_root_frame_forgets_place_and_heading_but_keeps_heights(stoop):
    motion = stoop.at(np.arange(20))
    moved = transformed(motion, -1.0, np.array([10.0, 20.0]))
    moved[:, 2] += 0.25
    plain, other = (local_positions(recording_of(m).links[:, 0]) for m in (motion, moved))
    assert other - [0, 0, 0.25] == pytest.approx(plain, abs=1e-5)
    assert plain[:, 0, :2] == pytest.approx(0, abs=1e-6)
    on_a_hill = local_positions(recording_of(moved).links[:, 0], np.full(20, 0.25, np.float32))
    assert on_a_hill == pytest.approx(plain, abs=1e-5)


def test_two_seconds_after_every_start_do_not_count(stoop):
    motion = stoop.at(np.arange(240))
    wrong = motion.copy()
    wrong[:60, 7:] = 0.0
    wrong[120:180, 7:] = 0.0
    assert imitation_error(recording_of(wrong, restarts=[(119, 0)]), stoop).mean == pytest.approx(0, abs=2e-5)
    assert imitation_error(recording_of(wrong), stoop).mean > 0.01


def test_without_a_stretch_of_three_seconds_there_is_no_error(stoop):
    found = imitation_error(recording_of(stoop.at(np.arange(89))), stoop)
    assert found.mean is None and found.std is None and found.frames == 0


def test_a_short_clip_that_does_not_repeat_is_matched_in_pieces(stoop):
    single = replace(stoop, cyclic=False)
    motion = np.concatenate([np.tile(single.qpos, (3, 1))[:60], np.tile(single.qpos, (3, 1))])
    found = matches(recording_of(motion), single)
    assert [part.segment for part in found] == [(0, 60, 89), (0, 89, 118), (0, 118, 147)]
    assert all(part.errors == pytest.approx(0, abs=1e-6) for part in found)


def test_of_a_long_clip_the_stretch_most_alike_counts():
    walk = load_clip("walk")
    piece = replace(walk, qpos=walk.qpos[:1500])
    found = matches(recording_of(walk.qpos[700:900]), piece)
    assert found[0].frames.tolist() == list(range(760, 900)) and found[0].errors == pytest.approx(0, abs=1e-6)


# ---- sliding and jerk --------------------------------------------------------------------------------------------


def test_jerk_of_a_cubic_is_its_third_derivative():
    t = np.arange(40) * CONTROL_DT
    positions = np.stack([2.0 * t**3, 5 * t**2 + t, 0 * t], axis=-1)[:, None].repeat(15, axis=1)
    assert mean_jerk(positions) == pytest.approx(12.0, rel=1e-6)


def test_the_clip_itself_has_jerk_ratio_one_across_its_seam(stoop):
    motion = stoop.at(np.arange(3 * stoop.period + 3 + 1))
    assert jerk_ratio(recording_of(motion[: stoop.period + 3]), stoop) == pytest.approx(1, abs=1e-3)
    assert jerk_ratio(recording_of(motion[: 3 * stoop.period + 3]), stoop) == pytest.approx(1, abs=1e-3)
    assert clip_jerk(stoop) > 10


def test_jumps_at_restarts_are_no_jerk_and_no_sliding(four, stoop):
    motion = stoop.at(np.arange(4 * stoop.period + 1))
    jumped = motion.copy()
    cut = 2 * stoop.period
    jumped[cut:, :2] += 5.0
    smooth, broken = recording_of(motion), recording_of(jumped, restarts=[(cut - 1, 0)])
    assert jerk_ratio(broken, stoop) == pytest.approx(jerk_ratio(smooth, stoop), rel=0.1)
    assert jerk_ratio(recording_of(jumped), stoop) > 50
    assert slips(broken, four).max() <= slips(smooth, four).max() + 1e-6


def test_sliding_of_a_clip_equals_its_quality_check(four, stoop):
    found = slips(recording_of(stoop.at(np.arange(stoop.period + 1))), four)
    assert np.median(found) == pytest.approx(check(stoop, "quiet").slip_median_cm_s, abs=0.3)


def test_a_statue_pushed_along_slides_at_the_speed_of_the_push(four, stoop):
    standing = stoop.at([0]).repeat(30, axis=0)
    grounded = slips(recording_of(standing), four)
    assert len(grounded) == 29 and grounded == pytest.approx(0, abs=1e-6)
    standing[:, 0] += 0.2 * np.arange(30) / FPS
    assert slips(recording_of(standing), four) == pytest.approx(20.0, abs=1e-3)


# ---- restarts, targets, figures ----------------------------------------------------------------------------------


def test_restarts_are_counted_as_the_worlds_report_them(four):
    found = record(Flail(), four, 120, seed=3)
    env = open_worlds(STOOP, 4, num_threads=1)
    env.reset(seed=3)
    ended = [env.step(Flail().predict(np.zeros((4, 784)), deterministic=True)[0])[2:4] for _ in range(120)]
    assert np.array_equal(found.restarts, [terminated | truncated for terminated, truncated in ended])
    assert found.restarts.sum() > 4 and not any(truncated.any() for _, truncated in ended)
    assert sum(found.ends.values()) == found.restarts.sum() and set(found.ends) <= {"fall", "lost", "diverged"}
    lengths = [stop - start for _, start, stop in found.segments()]
    assert sum(lengths) == 4 * 121 and len(lengths) == 4 + found.restarts.sum()
    assert found.seconds == pytest.approx(16.0)


def test_targets_count_when_they_are_replaced():
    counted = _Targets(np.zeros(2, bool))
    target, far, near = np.zeros((2, 2)), np.full((2, 2), 3.0), np.array([[0.3, 0.3], [0.4, 0.4]])
    none, both = np.zeros(2, bool), np.ones(2, bool)
    counted.note(target, near, none)
    counted.note(target, far, both)
    assert (counted.count, counted.reached) == (2, 1)
    counted.note(target, near, np.array([True, False]))  # in the step of a restart the root is elsewhere already
    assert (counted.count, counted.reached) == (3, 1)
    counted.note(target, far, both)
    assert (counted.count, counted.reached) == (5, 1)


def test_straight_ahead_means_where_each_world_starts_out(four):
    seen = []

    class Watch(Flail):
        def predict(self, observation, *rest, **names):
            seen.append(four.worlds.goals.held_heading.copy())
            return super().predict(observation, *rest, **names)

    found = record_straight(Watch(), four, 0.8, seed=1, seconds=2.0)
    w, x, y, z = np.moveaxis(found.links[0, :, 0, 3:7], -1, 0)
    assert seen[0] == pytest.approx(np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)), abs=1e-5)
    assert found.restarts.any() and np.isfinite(seen).all()
    assert np.isnan(four.worlds.goals.held_heading).all()


def test_the_same_seed_gives_the_same_figures_and_another_does_not(four, tmp_path):
    policy = load_policy(save_tiny_base(tmp_path), four)
    one, two, other = (evaluate(policy, four, 8.0, seed).figures for seed in (5, 5, 6))
    assert one == two and other.goal_reward != one.goal_reward
    assert one.seconds == 8.0 and one.seed == 5 and 0 < one.goal_reward <= 1
    with pytest.raises(ValueError, match="one step of 4 worlds"):
        evaluate(policy, four, 0.01)


def test_another_speed_is_asked_for_straight_ahead_alone(four, tmp_path):
    policy = load_policy(save_tiny_base(tmp_path), four)
    usual, slow = evaluate(policy, four, 1.0), evaluate(policy, four, 1.0, speed=0.4)
    assert (usual.free.asked_speed, usual.straight.asked_speed) == (None, reference_speed(four))
    assert slow.straight.asked_speed == slow.figures.asked_speed_m_s == 0.4
    assert (slow.free.qpos == usual.free.qpos).all() and (slow.straight.qpos != usual.straight.qpos).any()
    base = record_base(policy, four, 0, base=policy, speed=0.4)
    assert (base.qpos == slow.straight.qpos).all()


def test_falls_per_minute_count_every_end(four):
    found = evaluate(Flail(), four, 20.0, 0)
    assert found.figures.falls_per_minute == pytest.approx(3 * found.free.restarts.sum(), abs=1e-3)
    mixed = replace(found.free, ends=Counter(fall=4, lost=2))
    assert figures_of(four, mixed, found.straight, None, 0).lost_per_minute == pytest.approx(6.0)
    assert found.figures.goal_reward == pytest.approx(found.free.rewards.mean(), abs=1e-4)


def test_the_speed_is_the_clips(four, stoop):
    assert reference_speed(four) == pytest.approx(stoop.mean_speed)


def test_stretches_of_rollouts_become_clips(stoop):
    motion = stoop.at(np.arange(200))
    found = recording_of(motion, motion, restarts=[(49, 0), (20, 1)])
    assert longest(found, 100.0) == (1, 21, 200)
    assert longest(found, 1.0, skip=2.0) == (1, 81, 112)
    clip = clip_of(found, longest(found, 2.0), stoop.joint_names, "piece")
    assert clip.qpos == pytest.approx(motion[21:82]) and clip.name == "piece"
    assert typical_clip(found, stoop, stoop.joint_names, "typical").seconds == pytest.approx(1.2)
    broken = recording_of(motion[:8], restarts=[(i, 0) for i in range(7)])
    with pytest.raises((ValueError, MotionError), match="needs 6"):
        longest(broken, 1.0)
