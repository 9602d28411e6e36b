"""Gaits of motions whose gait is known."""

from dataclasses import replace

import numpy as np
import pytest
from evaluation_cases import recording_of

from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.model.soles import TOUCHING, sole_corners
from adapt_envs.motion.clip import FPS
from adapt_envs.motion.library import STYLES, load_clip
from sb3_adaptnet.evaluation.gait import Gait, cadence, clearances, clip_gait, flat, gait_of

RIGHT, LEFT = 11, 14


def feet_of(frequency, seconds, phase=0.0):
    """Feet (T, 6) that swing ahead and rise in turn, `frequency` times a second each."""
    turn = 2 * np.pi * frequency * np.arange(round(seconds * FPS)) * CONTROL_DT + phase
    right, left = ([0.3 * np.sin(t), 0 * t + 0.1, 0.1 * np.maximum(np.cos(t), 0)] for t in (turn, turn + np.pi))
    return np.stack([*right, *left], axis=1)


@pytest.mark.parametrize("frequency", [0.45, 0.8, 1.07, 1.9, 2.6])
def test_the_cadence_is_that_of_strides_not_of_steps(frequency):
    assert cadence([feet_of(frequency, 8.0)]) == pytest.approx(frequency, rel=0.01)


def test_noise_does_not_change_the_cadence_and_has_none():
    noise = np.random.default_rng(0).normal(size=(240, 6))
    assert cadence([feet_of(0.9, 8.0) + 0.03 * noise]) == pytest.approx(0.9, rel=0.02)
    assert cadence([noise]) is None and cadence([np.zeros((240, 6))]) is None


def test_short_stretches_are_pooled():
    stretches = [feet_of(1.1, 2.5, phase) for phase in range(6)]
    assert cadence(stretches) == pytest.approx(1.1, rel=0.01)
    assert cadence([feet_of(1.1, 1.2)]) is None


def test_one_period_of_a_loop_is_enough():
    assert cadence([feet_of(0.5, 2.0)], looped=True) == pytest.approx(0.5)


@pytest.mark.parametrize("name", STYLES)
def test_a_style_steps_once_a_period(name):
    clip = load_clip(name)
    assert clip_gait(clip, 1.0).cadence_hz == pytest.approx(FPS / clip.period, rel=1e-3)


def test_hills_under_an_uneven_gait_do_not_change_its_cadence():
    clip, rng = load_clip("JauntySkip"), np.random.default_rng(1)
    steps = np.repeat(rng.uniform(0.9, 1.1, 12), clip.period)[: 9 * clip.period]  # strides that differ in length
    links = recording_of(clip.at(np.round(np.cumsum(steps)).astype(int))).links[:, 0]

    def hills(points):
        return (0.5 * np.sin(0.9 * points[..., 0])).astype(points.dtype)

    expected = gait_of([links]).cadence_hz
    links[..., 2] += hills(links[:, :1, :2])
    assert gait_of([links], floor_at=hills).cadence_hz == pytest.approx(expected)


def test_a_clip_played_back_has_its_own_gait():
    clip = load_clip("JauntySkip")
    links = recording_of(clip.at(np.arange(5, 5 + 6 * clip.period))).links[:, 0]
    found, expected = gait_of([links]), clip_gait(clip, 1.0)
    assert found.cadence_hz == pytest.approx(expected.cadence_hz, rel=0.01)
    assert found.foot_height_m == pytest.approx(expected.foot_height_m, rel=0.01)
    assert found.flight_share == pytest.approx(expected.flight_share) and expected.flight_share > 0.1


def test_of_a_long_clip_the_stretches_at_the_speed_count():
    walk = load_clip("walk")
    slow, fast = clip_gait(walk, 0.8), clip_gait(walk, 1.4)
    assert 0.9 < slow.cadence_hz < fast.cadence_hz < 1.2
    assert clip_gait(load_clip("run"), 3.0).flight_share > 0.1 > slow.flight_share
    single = replace(walk, qpos=walk.qpos[300:390])
    assert clip_gait(single, 5.0).foot_height_m == pytest.approx(slow.foot_height_m, rel=0.1)


def test_faster_pieces_that_curve_do_not_count_though_they_end_as_far_away():
    stoop, piece = load_clip("Stoop"), 4 * FPS
    ahead, around = np.arange(piece) / FPS, np.linspace(0, np.pi, piece)
    slow, fast = stoop.at(np.arange(piece)), stoop.at(3 * np.arange(piece) // 2)
    slow[:, :2] = np.stack([ahead, 0 * ahead], axis=1)  # 1 m/s, straight on
    fast[:, :2] = 2 * np.stack([1 - np.cos(around), np.sin(around)], axis=1)  # half a circle of the same ends
    clip = replace(stoop, qpos=np.concatenate([slow, *[fast] * 9]), cyclic=False)
    assert clip_gait(clip, 1.0).cadence_hz == pytest.approx(FPS / stoop.period, rel=0.02)


def test_the_foot_height_is_the_mean_over_the_feet_of_the_99th_percentile_above_the_ground():
    links = recording_of(load_clip("Stoop").at(np.zeros(101, int))).links[:, 0]  # nothing repeats: one stride
    links[:, RIGHT, 2] = 0.05 + 0.2 * np.arange(101) / 100
    links[:, LEFT, 2] = 0.05
    assert gait_of([links]).foot_height_m == pytest.approx((0.248 + 0.05) / 2, abs=1e-6)
    assert gait_of([links], floor_at=lambda xy: 0.01 + 0 * xy[..., 0]).foot_height_m == pytest.approx(0.139, abs=1e-6)


def played(name, periods):
    clip = load_clip(name)
    return recording_of(clip.at(np.arange(periods * clip.period))).links[:, 0]


def test_a_ditch_that_a_foot_swings_over_is_no_lift():
    links, soles = played("Stomp", 4), sole_corners(compile_model())
    feet = links[:, [RIGHT, LEFT]]
    trodden = feet[clearances(feet, soles) <= TOUCHING][:, :2]

    def ditches(points):
        away = np.linalg.norm(points[..., None, :] - trodden, axis=-1).min(axis=-1)
        return np.where(away < 0.16, 0.0, -0.3)  # as far as soles reach

    above_the_point_below = feet[..., 2] - ditches(feet[..., :2])
    on_flat, over_ditches = gait_of([links]), gait_of([links], floor_at=ditches)
    assert np.percentile(above_the_point_below, 99) > on_flat.foot_height_m + 0.1
    assert over_ditches.foot_height_m == pytest.approx(on_flat.foot_height_m, abs=0.002)
    assert over_ditches.flight_share == on_flat.flight_share


def test_a_stair_that_is_walked_up_is_no_lift_beyond_the_clips():
    links = played("Stomp", 6)
    on_flat = gait_of([links]).foot_height_m
    climbing = links.copy()
    climbing[..., 2] += 0.1 * links[:, 0, 0][:, None]
    found = gait_of([climbing], floor_at=lambda points: 0.1 * points[..., 0]).foot_height_m
    assert found == pytest.approx(on_flat, abs=0.04)


def test_one_high_step_among_many_does_not_count_and_a_missing_one_neither():
    period = load_clip("Kicking").period
    links = played("Kicking", 7)
    usual = gait_of([links]).foot_height_m
    for factor in (0.3, 3.0):
        odd = links.copy()
        odd[period : 2 * period, [RIGHT, LEFT], 2] *= factor
        assert gait_of([odd]).foot_height_m == pytest.approx(usual, rel=0.03)
    odd = links.copy()
    odd[: 5 * period, [RIGHT, LEFT], 2] *= 0.3
    assert gait_of([odd]).foot_height_m < 0.5 * usual


def test_both_feet_must_leave_the_ground_to_fly():
    feet = np.zeros((4, 2, 13), np.float32)
    feet[..., 3] = 1.0
    soles = sole_corners(compile_model())
    feet[..., 2] = -soles[..., 2].min() + np.array([[0, 0], [0.1, 0], [0.1, 0.014], [0.1, 0.016]])
    links = np.zeros((4, 15, 13), np.float32)
    links[..., 3] = 1.0

    def share(floor_at=flat):
        links[:, [RIGHT, LEFT]] = feet
        return gait_of([links], floor_at=floor_at).flight_share

    assert share() == 0.25
    assert share(lambda xy: 0.1 + 0 * xy[..., 0]) == 0
    assert clearances(feet, soles)[:, 1] == pytest.approx([0, 0, 0.014, 0.016], abs=1e-6)
    feet[3, 1, 3:7] = np.cos(0.2), 0, np.sin(0.2), 0  # a toe points down and touches
    assert share() == 0


def test_without_a_stretch_there_is_no_gait():
    assert gait_of([]) == Gait(None, None, None)
