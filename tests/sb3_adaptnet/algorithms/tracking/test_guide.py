"""Guides turn at a bounded rate, wait for their characters, and find the phase again."""

import numpy as np
import pytest
import torch

from adapt_envs import make_vector
from sb3_adaptnet.algorithms.tracking.guide import CONTROL_DT, Guide, Guiding
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.character import Character


@pytest.fixture
def guide():
    env = make_vector("AdaptNet/Humanoid-GooseStep-v0", 1)
    motion = TrackedMotion.of(Character.of(env.model), torch.device("cpu"), [env.reference_states])
    guide = Guide(motion, 5)
    guide.fastest_turn = 0.6
    guide.restart(np.arange(5), motion.seen[:5], motion.facing.numpy()[:5])
    return guide


def at_own_speed(guide):
    """Preferred speeds and those of the roots (5,) each, alike."""
    return (np.full(5, guide.motion.gaits.speeds[0]),) * 2


def test_a_guide_begins_where_its_character_faces(guide):
    assert np.allclose(guide.headings, 0, atol=1e-6)
    assert np.array_equal(guide.phases, np.arange(5))


def test_it_turns_to_the_target_as_fast_as_it_may(guide):
    angles = np.array([0.0, 0.4, 1.5, -1.5, 3.0])
    target, headings = 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1), []
    for _ in range(300):
        guide.advance(target, guide.headings + guide._facing[guide.phases], *at_own_speed(guide))
        headings.append(guide.headings.copy())
    rates = np.diff(headings, axis=0) / CONTROL_DT
    assert np.abs(rates).max() == pytest.approx(0.6)
    assert np.abs(np.diff(rates, axis=0)).max() <= guide.turn_acceleration * CONTROL_DT + 1e-9
    assert np.allclose(headings[-1], angles, atol=1e-3)


def test_who_stands_turns_slowly(guide):
    """The guide's rate grows with the character's speed, from a share of what it may be to all of it."""
    guide.turn_at_rest = 0.25
    wanted, _ = at_own_speed(guide)
    moving = wanted * [0.0, 0.2, 0.6, 1.0, 1.5]
    target = np.array([[0.0, 5.0]] * 5)
    for _ in range(15):
        guide.advance(target, guide.headings + guide._facing[guide.phases], wanted, moving)
    assert guide.turn_rates == pytest.approx(0.6 * np.array([0.25, 0.4, 0.7, 1.0, 1.0]))


def test_fast_turns_end_in_time(guide):
    guide.fastest_turn, guide.turn_acceleration, guide.turn_gain = 4.5, 9.0, 5.0
    angles, headings = np.array([0.2, 1.0, -2.0, 3.0, -3.0]), []
    target = 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for _ in range(60):
        guide.advance(target, guide.headings + guide._facing[guide.phases], *at_own_speed(guide))
        headings.append(guide.headings.copy())
    beyond = np.sign(angles) * (np.array(headings) - angles)
    assert beyond.max() < 0.1  # hardly overshoots
    assert np.abs(beyond[44]).max() < 0.05  # three radians in a second and a half
    assert np.abs(np.diff(headings, axis=0)).max() > 3.5 * CONTROL_DT


@pytest.mark.parametrize(
    ("angles", "signs"),
    [((2.5, 2.6, 3.1, -3.1, -2.6), (1, 1, 1, 1, 1)), ((-2.5, -1.5, 0.5, 2.5, -2.6), (-1, -1, 1, 1, 1))],
)
def test_targets_about_straight_behind_are_turned_to_by_the_left(guide, angles, signs):
    guide.left_from_behind, rates = 0.6, []
    target = 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for _ in range(300):
        guide.advance(target, guide.headings + guide._facing[guide.phases], *at_own_speed(guide))
        rates.append(guide.turn_rates * signs)
    assert np.min(rates) > -0.05
    there = [angle + 2 * np.pi * (sign != np.sign(angle)) for angle, sign in zip(angles, signs, strict=True)]
    assert np.allclose(guide.headings, there, atol=1e-3)


def test_it_keeps_its_direction_near_the_target(guide):
    guide.advance(np.full((5, 2), 0.1), guide.headings, *at_own_speed(guide))
    assert np.allclose(guide.headings, 0, atol=1e-6)


def test_it_waits_for_its_character(guide):
    for _ in range(300):
        guide.advance(np.array([[0.0, 5.0]] * 5), guide._facing[guide.phases], *at_own_speed(guide))
    assert np.allclose(guide.headings, 1.5, atol=0.05)


def test_it_finds_its_phase_again(guide):
    true = guide.motion.gaits.shifted(guide.phases, np.array([0, 1, -2, 2, 5]))
    seen = guide.motion.seen[true]
    assert np.allclose(guide.errors(seen)[0], 0)
    guide.resynchronise(seen)
    assert np.array_equal(guide.phases[:4], true[:4])
    assert abs(guide.phases[4] - true[4]) == 3


def test_its_tempo_is_the_root_of_the_speed(guide):
    speeds = guide.motion.gaits.speeds[0] * np.array([1.0, 0.9, 1.1, 0.1, 9.0])
    before = guide.phases.copy()
    for _ in range(40):
        guide.advance(np.full((5, 2), 0.1), guide.headings, speeds, speeds)
    gone = (guide.phases + guide._between - before) % len(guide.motion)
    assert np.allclose(gone, 40 * np.clip(np.sqrt([1.0, 0.9, 1.1, 0.1, 9.0]), 0.87, 1.15))


def test_the_style_counts_less_in_turns(guide):
    guide.least_style, angles = 0.2, np.array([0.0, 0.24, 0.8, -0.8, 3.0])
    target = 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    facing = guide._facing[guide.motion.gaits.shifted(guide.phases, 1)]
    guide.advance(target, facing, *at_own_speed(guide))
    assert np.allclose(guide.style, [1, 1, 0.3, 0.3, 0.2], atol=1e-6)
    assert (guide.calm_steps > 1000).tolist() == [True, True, False, False, False]
    guide.least_style = 1.0
    guide.advance(target, facing, *at_own_speed(guide))
    assert np.allclose(guide.style, 1)
    assert guide.calm_steps[4] == 1
    guide.restart(np.array([4]), guide.motion.seen[:5], facing)
    assert guide.calm_steps[4] > 1000


def test_what_no_guide_can_do_is_refused():
    with pytest.raises(ValueError, match="turn_rate"):
        Guiding(turn_rate={0: -1.0})
    with pytest.raises(ValueError, match="left_from_behind"):
        Guiding(left_from_behind=-0.1)
    with pytest.raises(ValueError, match="left_from_behind is an angle below pi, not {0: 0.0, 9: 40.0}"):
        Guiding(left_from_behind={0: 0.0, 9: 40.0})
    with pytest.raises(ValueError, match="turn_at_rest is a share, at most 1, not 1.2"):
        Guiding(turn_at_rest=1.2)
    with pytest.raises(ValueError, match="must be positive"):
        Guiding(longest_lead=0.0)
    for gaits in (0.9, [0.9, 0.0], "fast"):
        with pytest.raises(ValueError, match="list of speeds"):
            Guiding(gaits=gaits)


@pytest.fixture(scope="module")
def many_gaits():
    env = make_vector("AdaptNet/Humanoid-Walk-v0", 1)
    references = env.reference_gaits([0.6, 1.0, 1.4])
    return TrackedMotion.of(Character.of(env.model), torch.device("cpu"), references)


def test_a_guide_changes_to_the_gait_of_its_speed(many_gaits):
    gaits, guide = many_gaits.gaits, Guide(many_gaits, 3)
    assert gaits.of(gaits.starts).tolist() == gaits.of(gaits.starts + gaits.lengths - 1).tolist() == [0, 1, 2]
    guide.restart(np.arange(3), many_gaits.seen[[0, 0, 0]], np.zeros(3))
    assert guide.phases.tolist() == [0, 0, 0]
    for _ in range(100):
        guide.advance(np.full((3, 2), 0.1), guide.headings, *(np.array([0.5, 1.0, 2.0]),) * 2)
        assert gaits.of(guide.phases).tolist() == [0, 1, 2]


def test_gaits_meet_in_like_poses(many_gaits):
    gaits, phases = many_gaits.gaits, np.arange(len(many_gaits))
    assert np.array_equal(gaits.at_speeds(phases, gaits.speeds[gaits.of(phases)]), phases)
    slow = gaits.at_speeds(phases, np.full(len(phases), 0.6))
    assert (gaits.of(slow) == 0).all()
    apart = np.linalg.norm(many_gaits.seen[phases, :, :3] - many_gaits.seen[slow, :, :3], axis=-1).mean(axis=-1)
    assert apart.max() < 0.12
    assert many_gaits.speeds.numpy()[slow] == pytest.approx(gaits.speeds[0])
