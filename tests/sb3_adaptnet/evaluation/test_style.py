"""Styles that are there, and ones that are not."""

from dataclasses import replace

import numpy as np
import pytest
from evaluation_cases import STOOP, recording_of, save_tiny_adaptation, save_tiny_base

from adapt_envs.model.build import compile_model
from adapt_envs.motion.clip import transformed
from adapt_envs.motion.library import load_clip
from adapt_envs.motion.on_body import shown_by
from adapt_envs.motion.quality import foot_corners
from sb3_adaptnet import load_policy
from sb3_adaptnet.evaluation.alpha import record_base
from sb3_adaptnet.evaluation.gait import Gait
from sb3_adaptnet.evaluation.imitation_error import BOUNDED, aligned_errors, imitation_error, matches, world_error
from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.evaluation.style import failed_tests, style_figures, tempo_error_of_base

FRAMES, FEET = np.arange(301), [11, 14]
BASE_ERROR = 0.144  # of `walk` on GooseStep [m]


@pytest.fixture(scope="module")
def goose():
    return load_clip("GooseStep")


@pytest.fixture(scope="module")
def worlds():
    return open_worlds("AdaptNet/Humanoid-GooseStep-v0", 1, num_threads=1)


@pytest.fixture(scope="module")
def walking():
    return recording_of(load_clip("walk").qpos[3000:3301])


# ---- visible or not ----------------------------------------------------------------------------------------------


def test_the_clip_itself_has_no_error_and_is_visible(worlds, goose):
    found = style_figures(worlds, recording_of(transformed(goose.at(FRAMES), 2.0, np.array([3.0, -1.0]))), BASE_ERROR)
    assert found.visible and not found.failed_tests
    assert found.tempo_error_m == pytest.approx(0, abs=1e-4) and found.world_error_m == pytest.approx(0, abs=1e-4)
    assert found.cadence_hz == pytest.approx(found.clip_cadence_hz, rel=0.01)
    assert found.foot_height_m == pytest.approx(found.clip_foot_height_m, rel=0.01)
    assert found.flight_share == found.clip_flight_share == 0
    assert found.speed_m_s == pytest.approx(found.asked_speed_m_s, rel=0.03)


def test_the_clip_at_double_tempo_is_not_visible(worlds, goose):
    doubled = recording_of(goose.at(2 * FRAMES))
    found = style_figures(worlds, doubled, BASE_ERROR)
    assert imitation_error(doubled, goose).mean == pytest.approx(0, abs=2e-5)
    assert found.visible is False and found.failed_tests[0].startswith("cadence 0.91 Hz: the clip's is 0.45 Hz")
    assert found.cadence_hz == pytest.approx(2 * found.clip_cadence_hz, rel=0.01) and found.tempo_error_m > 0.05
    assert found.speed_m_s == pytest.approx(2 * found.asked_speed_m_s, rel=0.03)


def test_the_clip_on_the_spot_is_not_visible(worlds, goose):
    qpos = goose.at(FRAMES)
    qpos[:, :2] = 0
    found = style_figures(worlds, recording_of(qpos), BASE_ERROR)
    assert found.visible is False and found.tempo_error_m == pytest.approx(0, abs=1e-4)
    assert found.failed_tests == (
        f"speed 0.00 m/s: what is asked for is {found.asked_speed_m_s:.2f} m/s, 0.75 to 1.25 of it wanted",
    )


def test_the_clip_with_its_kicks_cut_off_is_not_visible(worlds, goose):
    whole = recording_of(goose.at(FRAMES))
    links = whole.links.copy()
    links[:, :, FEET, 2] = np.minimum(links[:, :, FEET, 2], 0.15)
    found = style_figures(worlds, replace(whole, links=links), BASE_ERROR)
    assert found.visible is False
    assert found.failed_tests == ("foot height 0.15 m: the clip's is 0.42 m, 0.75 to 1.3 of it wanted",)


def test_a_skip_that_stays_on_the_ground_is_not_visible():
    skip, worlds = load_clip("JauntySkip"), open_worlds("AdaptNet/Humanoid-JauntySkip-v0", 1, num_threads=1)
    grounded = skip.at(FRAMES)
    assert style_figures(worlds, recording_of(grounded), BASE_ERROR).visible
    grounded[:, 2] -= foot_corners(compile_model(), grounded)[..., 2].min(axis=1)
    found = style_figures(worlds, recording_of(grounded), BASE_ERROR)
    assert found.visible is False and len(found.failed_tests) == 1 and "flight share 0%" in found.failed_tests[0]


@pytest.mark.parametrize("body", [
    {"morphology": "long_body"}, {"morphology": "super_long_legs"}, {"locked": ("ankle",)},
], ids=["long body", "long legs", "stiff ankles"])  # fmt: skip
def test_a_body_is_compared_with_what_it_would_show(goose, body):
    worlds = open_worlds("AdaptNet/Humanoid-GooseStep-v0", 1, num_threads=1, **body)
    model = worlds.worlds.reference.model
    shown = recording_of(shown_by(goose, model).at(FRAMES), body=model)
    found = style_figures(worlds, shown, BASE_ERROR)
    assert found.visible and not found.failed_tests
    assert found.tempo_error_m == pytest.approx(0, abs=1e-4) and found.world_error_m == pytest.approx(0, abs=1e-4)
    assert found.foot_height_m == pytest.approx(found.clip_foot_height_m, rel=0.01)
    assert imitation_error(shown, goose, BOUNDED, model).mean == pytest.approx(0, abs=1e-4)
    assert imitation_error(shown, goose, BOUNDED).mean > 0.005
    limp = load_clip("Limp")
    other = recording_of(shown_by(limp, model).at(FRAMES), body=model)
    assert style_figures(worlds, other, BASE_ERROR).visible is False


def test_the_base_does_not_show_the_style(worlds, goose, walking):
    error = imitation_error(walking, goose, BOUNDED).mean
    found = style_figures(worlds, walking, error)
    assert found.visible is False and found.tempo_error_m == found.base_tempo_error_m == pytest.approx(error, abs=1e-4)
    assert any(test.startswith("tempo error") and "at most 0.5 of it" in test for test in found.failed_tests)


def test_without_a_base_or_a_style_nothing_can_be_said(worlds, goose, walking):
    found = style_figures(worlds, recording_of(goose.at(FRAMES)))
    assert found.visible is None and not found.failed_tests and found.base_tempo_error_m is None
    plain = open_worlds("AdaptNet/Humanoid-Walk-v0", 1, num_threads=1)
    found = style_figures(plain, walking)
    assert found.visible is None and not found.failed_tests and found.tempo_error_m == 0
    assert tempo_error_of_base(None, plain, 0) is tempo_error_of_base(None, worlds, 0) is None


def test_who_never_stays_up_shows_nothing(worlds, goose):
    found = style_figures(worlds, recording_of(goose.at(FRAMES[:80])), BASE_ERROR)
    assert (
        found.visible is False
        and found.speed_m_s is found.cadence_hz is found.tempo_error_m is found.world_error_m is None
    )
    assert [test.split(":")[0] for test in found.failed_tests] == [
        "cadence none", "foot height none", "tempo error none", "speed none",
    ]  # fmt: skip


def test_an_adaptation_that_was_merged_has_no_base_to_measure(tmp_path):
    env, base = open_worlds(STOOP, 1, num_threads=1), save_tiny_base(tmp_path)
    adapted = load_policy(save_tiny_adaptation(base, "one"), env, base=base)
    adapted.alpha = 0.7
    plain, again = (
        record_base(load_policy(base, env), env, 0, base=load_policy(base, env)),
        record_base(adapted, env, 0),
    )
    assert np.array_equal(plain.qpos, again.qpos) and adapted.alpha == 0.7
    adapted.merge()
    assert record_base(adapted, env, 0) is None


@pytest.mark.parametrize("cadence, height, flight, error, count", [
    (0.86, 0.31, 0.06, 0.075, 0), (1.14, 0.51, 0.14, 0.0, 0), (0.84, 0.4, 0.1, 0.05, 1), (1.0, 0.29, 0.1, 0.05, 1),
    (1.0, 0.53, 0.1, 0.05, 1), (1.0, 0.4, 0.04, 0.05, 1), (1.0, 0.4, 0.16, 0.05, 1), (1.16, 0.2, 0.3, 0.08, 4),
])  # fmt: skip
def test_the_bounds_of_the_tests(cadence, height, flight, error, count):
    assert len(failed_tests(Gait(cadence, height, flight), Gait(1.0, 0.4, 0.1), error, 0.15, 0.9, 1.0)) == count
    assert len(failed_tests(Gait(1.0, 0.4, flight), Gait(1.0, 0.4, 0.05), 0.01, 0.15, 0.9, 1.0)) == 0


@pytest.mark.parametrize(("speed", "count"), [(0.61, 0), (0.99, 0), (0.59, 1), (1.01, 1), (None, 1)])
def test_a_style_gets_ahead_as_fast_as_it_shall(speed, count):
    same = Gait(1.0, 0.4, 0.1)
    assert len(failed_tests(same, same, 0.01, 0.15, speed, 0.8)) == count


# ---- tempo and world ---------------------------------------------------------------------------------------------


def error_in_the_world(motion, clip):
    recording = recording_of(motion)
    return world_error(recording, clip, matches(recording, clip, BOUNDED))


@pytest.mark.parametrize("rate, hidden", [(1.0, True), (1.12, True), (0.88, True), (1.5, False), (0.6, False)])
def test_the_tempo_may_be_off_by_15_percent(goose, rate, hidden):
    error = imitation_error(recording_of(goose.at(np.round(rate * FRAMES).astype(int))), goose, BOUNDED).mean
    assert error < 0.01 if hidden else error > 0.04


def test_shift_and_turn_on_the_ground_are_no_error_in_the_world_and_height_is(goose):
    motion = transformed(goose.at(FRAMES), -1.3, np.array([5.0, 2.0]))
    motion[:, 2] += 0.07
    assert error_in_the_world(motion, goose) == pytest.approx(0.07, abs=2e-3)


def test_a_wrong_speed_counts_for_two_seconds(goose):
    motion = goose.at(FRAMES)
    motion[:, 0] += 0.2 * FRAMES / 30
    assert imitation_error(recording_of(motion), goose, BOUNDED).mean == pytest.approx(0, abs=1e-4)
    assert error_in_the_world(motion, goose) == pytest.approx(0.2 * 2 / 4, rel=0.05)


def test_links_are_aligned_as_well_as_they_can_be():
    there = np.random.default_rng(0).normal(size=(20, 15, 3)).astype(np.float32)
    c, s = np.cos(0.7), np.sin(0.7)
    here = there @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]], np.float32) + np.array([1, 2, 0], np.float32)
    assert aligned_errors(here, there) == pytest.approx(0, abs=1e-5)
    noisy = here + 0.1 * np.random.default_rng(1).normal(size=here.shape).astype(np.float32)
    assert (aligned_errors(noisy, there) ** 2).mean() <= (np.linalg.norm(noisy - here, axis=-1) ** 2).mean()
