"""Importing motion files: every dialect gives the same clip, which stands, keeps its limits and goes its way."""

import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from made_up_motions import LAFAN, MIXAMO, STRANGE, bvh_text, json_object, strange_map, write

from adapt_envs.features import rotations
from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion import quality
from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.importing.pipeline import import_motion
from adapt_envs.motion.importing.skeletons import REQUIRED, SIDES

DATA = os.environ.get("ADAPTNET_MOTION_DATA")
RECORDED = ("limp_walk.json", "joyful_walk.json", "walk1_subject1_100_1170.json", "131_01.bvh", "131_03.bvh")
FORGOTTEN = "set ADAPTNET_MOTION_DATA to a folder with official_json/ and bvh/ to test on recorded motions"


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> MotionClip:
    """The stick figure's walk from the plainest file."""
    return import_motion(write(tmp_path_factory.mktemp("plain"), "walk.bvh", bvh_text()))


DIALECTS = {
    "Mixamo, z up, metres": {"names": MIXAMO, "up": "z", "unit": 1.0},
    "LAFAN1, x up, inches": {"names": LAFAN, "up": "x", "unit": 0.0254},
    "XYZ channels": {"order": "XYZ"},
    "YZX channels, six per joint": {"order": "YZX", "six_channels": True},
    "Windows line ends": {},
}


@pytest.mark.parametrize("dialect", DIALECTS)
def test_dialects_give_the_same_clip(dialect, plain, tmp_path):
    text = bvh_text(**DIALECTS[dialect])
    if dialect.startswith("Windows"):
        text = text.replace("\n", "\r\n")
    clip = import_motion(write(tmp_path, "walk.bvh", text))
    np.testing.assert_allclose(clip.qpos, plain.qpos, atol=2e-4)


def test_a_map_makes_an_unknown_skeleton_known(plain, tmp_path):
    motion = write(tmp_path, "walk.bvh", bvh_text(names=STRANGE))
    with pytest.raises(MotionError, match="unknown skeleton.*--map.*bone_0_"):
        import_motion(motion)
    clip = import_motion(motion, write(tmp_path, "map.yml", yaml.safe_dump({"joints": strange_map()})))
    np.testing.assert_allclose(clip.qpos, plain.qpos, atol=2e-4)


def test_a_map_needs_only_the_required_roles(plain, tmp_path):
    joints = {role: joint for role, joint in strange_map().items() if role in REQUIRED}
    joint_map = write(tmp_path, "map.yml", yaml.safe_dump({"joints": joints, "up": "y", "drop": 3}))
    clip = import_motion(write(tmp_path, "walk.bvh", bvh_text(names=STRANGE)), joint_map)
    assert len(clip.qpos) == len(plain.qpos) - 3
    legs = [7 + i for i, name in enumerate(joint_names()) if "knee" in name]
    np.testing.assert_allclose(clip.qpos[5:, legs], plain.qpos[8:, legs], atol=0.05)


@pytest.mark.parametrize("frame_time", [1 / 120, 1 / 60, 1 / 24])
def test_resampled_to_30_hz(frame_time, plain, tmp_path):
    clip = import_motion(write(tmp_path, "walk.bvh", bvh_text(frames=round(2 / frame_time), frame_time=frame_time)))
    assert clip.seconds == pytest.approx(2, abs=0.07)
    assert clip.mean_speed == pytest.approx(plain.mean_speed, rel=0.02)
    shared = slice(0, min(len(clip.qpos), len(plain.qpos)) - 3)
    assert np.abs(clip.qpos[shared] - plain.qpos[shared]).mean() < np.radians(2)


def test_leading_t_pose_is_dropped(plain, tmp_path):
    clip = import_motion(write(tmp_path, "walk.bvh", bvh_text(t_pose=5)))
    assert len(clip.qpos) == len(plain.qpos) - 5
    arms = [7 + joint_names().index(f"{side}_shoulder_x") for side in SIDES]
    assert np.abs(clip.qpos[:, arms]).max() < np.radians(15)


def test_a_whole_clip_of_t_pose_is_kept(tmp_path):
    clip = import_motion(write(tmp_path, "walk.bvh", bvh_text(frames=30, t_pose=30)))
    right = clip.qpos[:, 7 + joint_names().index("right_shoulder_x")]
    np.testing.assert_allclose(right, np.radians(-90), atol=0.02)


def test_joint_angles_are_the_files(plain):
    """The stick figure turns its joints about the lateral axis alone: the angles come back as they were written."""
    time = np.arange(len(plain.qpos)) / 30
    swing = np.radians(20 * np.sin(2 * np.pi * time / 1.2))
    np.testing.assert_allclose(plain.qpos[:, 7 + joint_names().index("left_shoulder_y")], swing, atol=0.02)
    np.testing.assert_allclose(plain.qpos[:, 7 + joint_names().index("left_elbow")], np.radians(-25), atol=0.02)
    np.testing.assert_allclose(plain.qpos[:, 7 + joint_names().index("abdomen_y")], 0, atol=0.02)


def test_scaled_to_the_characters_legs(plain):
    own = 0.421546 + 0.40987
    assert np.ptp(plain.qpos[:, 0]) == pytest.approx(1.2 * plain.seconds * own / 0.8, rel=0.02)
    assert np.abs(plain.qpos[:, 1]).max() < 0.01


@pytest.mark.parametrize("kind", ["bvh", "json"])
def test_imports_stand_on_the_ground_and_keep_their_limits(kind, tmp_path):
    path = write(tmp_path, f"walk.{kind}", bvh_text(t_pose=2) if kind == "bvh" else json_object())
    measured = quality.check(import_motion(path))
    assert measured.limit_violation_deg == 0
    assert measured.penetration_cm < 0.2
    assert measured.slip_median_cm_s < 1


def test_official_json_at_another_rate(tmp_path):
    clip = import_motion(write(tmp_path, "walk.json", json_object(frames=120, fps=60)))
    assert len(clip.qpos) == 60


@pytest.mark.parametrize("kind", ["bvh", "json"])
def test_style_is_one_closed_cycle_along_x(kind, tmp_path):
    """The stick figure's gait cycle lasts 1.2 s: 36 frames; it closes exactly and goes on without a seam."""
    content = bvh_text(frames=110, up="z") if kind == "bvh" else json_object(frames=110)
    clip = import_motion(write(tmp_path, f"walk.{kind}", content), style=True)
    assert clip.cyclic and clip.period == 36
    np.testing.assert_allclose(clip.qpos[-1, 2:], clip.qpos[0, 2:], atol=1e-12)
    yaw, step = clip.cycle_transform
    assert abs(yaw) < 1e-9 and step[0] > 1.0 and abs(step[1]) < 1e-9
    np.testing.assert_allclose(clip.qpos[0, :2], 0, atol=1e-12)
    jumps = np.abs(np.diff(clip.at(np.arange(2 * clip.period + 1))[:, 7:], axis=0)).max(axis=1)
    assert jumps[clip.period - 1] <= 1.2 * jumps.max() and jumps[clip.period - 1] <= 2 * np.median(jumps) + 0.2


def test_style_of_a_turned_walk_still_heads_along_x(tmp_path):
    content = json_object(frames=110)
    for frame in content["frames"]:
        x = frame["pelvis"][0][0]
        frame["pelvis"] = [[5.0, 1 - x, 0.85], [0, 0, -np.sqrt(0.5), np.sqrt(0.5)]]
    clip = import_motion(write(tmp_path, "walk.json", content), style=True)
    assert clip.cycle_transform[1][0] > 1.0
    np.testing.assert_allclose(rotations.heading(clip.qpos[:, 3:7]), 0, atol=0.1)


def test_style_without_steps_is_refused(tmp_path):
    with pytest.raises(MotionError, match="stand.bvh: no gait cycle"):
        import_motion(write(tmp_path, "stand.bvh", bvh_text(frames=90, still=True)), style=True)


@pytest.mark.skipif(DATA is None, reason=FORGOTTEN)
@pytest.mark.parametrize("style", [False, True])
@pytest.mark.parametrize("name", RECORDED)
def test_recorded_motions(name, style):
    path = next(Path(str(DATA)).rglob(name), None)
    if path is None:
        pytest.skip(f"{name} is not in {DATA}")
    measured = quality.check(import_motion(path, style=style))
    assert measured.limit_violation_deg == 0
    assert measured.penetration_cm < 0.5
    assert measured.slip_median_cm_s < 2
