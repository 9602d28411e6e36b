"""A clip as other bodies show it: joint angles, steps, tempo, and the windows that discriminators see."""

import numpy as np
import pytest

from adapt_envs import AdaptVectorEnv, make_vector
from adapt_envs.features.heading_frame import heading_frame_features, pose_windows
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import build_character, compile_model
from adapt_envs.model.humanoid import CONTROL_DT, FEET, LINKS
from adapt_envs.model.morphology import MORPHOLOGIES, Morphology
from adapt_envs.model.soles import lowest_corner
from adapt_envs.motion.library import load_clip, reference_motion
from adapt_envs.motion.on_body import leg_length, shown_by

PLAIN = compile_model()
LEGS = {name: 1.5 for side in ("right", "left") for name in (f"{side}_thigh", f"{side}_shin")}


def shaped(length=None, locked=()):
    return compile_model(build_character(Morphology(length=length or {}), locked))


@pytest.fixture(scope="module")
def stoop():
    return load_clip("Stoop")


def test_the_plain_character_shows_the_clip_itself(stoop):
    shown = shown_by(stoop, PLAIN)
    np.testing.assert_allclose(shown.qpos, stoop.qpos, atol=1e-12)
    assert shown.joint_names == stoop.joint_names and shown.cyclic


def test_legs_half_as_long_again_make_such_steps_in_as_long_a_time_as_a_pendulum(stoop):
    body = shaped(LEGS)
    shown, slower = shown_by(stoop, body), np.sqrt(1.5)
    assert leg_length(body) == pytest.approx(1.5 * leg_length(PLAIN))
    assert shown.period == round(slower * stoop.period)
    assert shown.mean_speed == pytest.approx(slower * stoop.mean_speed, rel=0.02)  # a period is whole frames
    way, longer = (np.linalg.norm(clip.cycle_transform[1]) for clip in (stoop, shown))
    assert longer == pytest.approx(1.5 * way)
    for frame in range(0, stoop.period, 5):  # the same angles, but for what changes within half a frame
        there = np.abs(shown.qpos[:, 7:] - stoop.qpos[frame, 7:]).max(axis=1)
        assert there.min() < 0.15
    np.testing.assert_allclose(np.linalg.norm(shown.qpos[:, 3:7], axis=1), 1, atol=1e-12)


@pytest.mark.parametrize("body", [{"locked": ["right_knee"]}, {"morphology": "long_shins"}, {}])
@pytest.mark.parametrize("motion", ["run", "Stoop"])
def test_start_states_move_as_fast_as_their_heights_change(body, motion):
    """Feet of other legs are put where the clip's were, frame by frame, which moves the root up and down."""
    reference = reference_motion(motion, MORPHOLOGIES.get(body.get("morphology")), tuple(body.get("locked", ())))
    _, _, history = reference.states(np.arange(reference.num_states))
    before, now, after = (history[:, frame, 0] for frame in (1, 2, 3))
    np.testing.assert_allclose(now[:, 9], (after[:, 2] - before[:, 2]) / (2 * CONTROL_DT), atol=1e-3)


def test_feet_stay_on_the_ground_and_hardly_slide(stoop):
    """The stance foot of long legs goes back under the root as fast as the root goes ahead, as the plain one's does."""
    for body in (PLAIN, shaped(LEGS)):
        shown = shown_by(stoop, body)
        links = Kinematics(body).link_states(shown.at(np.arange(2 * shown.period)))
        assert np.abs(lowest_corner(body, links)).max() < 0.02
        feet = links[:, [LINKS.index(foot) for foot in FEET], :3]
        stance = feet[:-1, :, 2].argmin(axis=1)
        slid = np.linalg.norm(np.diff(feet[..., :2], axis=0)[np.arange(len(stance)), stance], axis=1)
        assert np.median(slid) * 30 < 0.25 * shown.mean_speed


def test_a_body_that_lacks_joints_shows_the_others(stoop):
    body = shaped(locked=("right_knee",))
    shown = shown_by(stoop, body)
    assert set(stoop.joint_names) - set(shown.joint_names) == {"right_knee"} and shown.period == stoop.period
    np.testing.assert_array_equal(
        shown.qpos[:, 7 + shown.joint_names.index("left_knee")], stoop.qpos[:, 7 + stoop.joint_names.index("left_knee")]
    )


def test_a_clip_that_does_not_repeat_keeps_its_ends():
    walk = load_clip("walk")
    shown = shown_by(walk, shaped(LEGS))
    assert not shown.cyclic and len(shown.qpos) == pytest.approx(np.sqrt(1.5) * len(walk.qpos), abs=1)
    np.testing.assert_allclose(shown.qpos[[0, -1], 7:], walk.qpos[[0, -1], 7:], atol=1e-12)


@pytest.mark.parametrize("name", ["long_body", "super_long_legs"])
def test_reference_windows_on_the_body_are_of_the_clip_that_it_shows(name):
    env = make_vector("AdaptNet/Humanoid-Stoop-v0", 1, num_threads=1, morphology=name, clip_on_body=True)
    reference = env.worlds.reference
    links = Kinematics(reference.model).link_states(reference.shown.at(np.arange(-4, reference.shown.period)))
    features = heading_frame_features(links[np.arange(4, len(links))[:, None] + np.arange(-4, 1)])
    shown, windows = pose_windows(features), env.sample_reference_windows(500, np.random.default_rng(0))
    assert all(np.isclose(window, shown, atol=1e-4).all(axis=(1, 2, 3)).any() for window in windows[:50])
    plain = reference_motion("Stoop", MORPHOLOGIES[name]).sample_windows(500, np.random.default_rng(0))
    assert np.abs(windows.mean(axis=0) - plain.mean(axis=0)).max() > 0.02


def test_a_style_asks_longer_legs_to_go_faster():
    shapes = (None, Morphology(length=LEGS))
    plain, long = (AdaptVectorEnv("Penguin", 1, num_threads=1, morphology=shape) for shape in shapes)
    slow, fast = (env.worlds.spec.speed_range for env in (plain, long))
    assert np.divide(fast, slow) == pytest.approx([np.sqrt(1.5)] * 2, rel=0.02)


def test_what_is_neither_true_nor_false_is_refused():
    with pytest.raises(ValueError, match="clip_on_body is 'yes', expected True or False"):
        make_vector("AdaptNet/Humanoid-Stoop-v0", 1, num_threads=1, clip_on_body="yes")
