"""Importing motion files: every dialect gives the same clip, which stands, keeps its limits and goes its way."""

import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from made_up_motions import CMU, LAFAN, MIXAMO, STRANGE, bvh_text, json_object, strange_map, write

from adapt_envs.features import rotations
from adapt_envs.motion import quality
from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.importing.bvh import read_bvh
from adapt_envs.motion.importing.draft import angles_within, character, from_poses, joint_names
from adapt_envs.motion.importing.pipeline import import_motion
from adapt_envs.motion.importing.planted_feet import sole_corners, standing
from adapt_envs.motion.importing.skeletons import FAMILIES, REQUIRED, SIDES, recognise

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


def test_official_json_poses_come_back(tmp_path):
    content = json_object()
    clip = import_motion(write(tmp_path, "walk.json", content))
    assert len(clip.qpos) == 40
    quats = np.roll([frame["right_upper_arm"] for frame in content["frames"]], 1, axis=1)
    wanted = angles_within(quats, "right_shoulder")
    columns = [7 + joint_names().index(f"right_shoulder_{axis}") for axis in "xyz"]
    np.testing.assert_allclose(clip.qpos[:, columns], wanted, atol=0.02)


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


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_every_family_recognises_its_own_names(family):
    names = [family.hips[0], family.neck[0], family.head[0]]
    for role in ("hip", "knee", "ankle", "toe", "shoulder", "elbow", "wrist"):
        names += [getattr(family, role)[0].format(side) for side in family.sides]
    found = recognise(Path("x.bvh"), tuple(names)).joints
    for side, word in zip(SIDES, family.sides, strict=True):
        assert found[f"{side}_knee"] == family.knee[0].format(word)
        assert found[f"{side}_shoulder"] == family.shoulder[0].format(word)


@pytest.mark.parametrize(
    ("shoulder", "upper"), [("LeftArm", LAFAN["arm"].format("Left")), ("LeftShoulder", CMU["arm"].format("Left"))]
)
def test_a_shoulder_is_an_arm_only_where_no_other_joint_is(shoulder, upper, tmp_path):
    """`LeftShoulder` is the upper arm in CMU files, a collar bone in LAFAN1's."""
    names = LAFAN if shoulder == "LeftArm" else CMU
    path = write(tmp_path, "x.bvh", bvh_text(names=names, frames=6))
    present = (*read_bvh(path).names, *(["LeftShoulder", "RightShoulder"] if names is LAFAN else []))
    assert recognise(path, present).joints["left_shoulder"] == upper


def test_bvh_channels_turn_in_the_order_they_stand(tmp_path):
    """R = Rz Rx Ry for channels Z X Y: a quarter turn about z, then one about the turned x."""
    text = """HIERARCHY
ROOT a {
  OFFSET 0 0 0
  CHANNELS 6 Zrotation Xrotation Yrotation Xposition Yposition Zposition
  JOINT b c {
    OFFSET 1 0 0
    CHANNELS 1 Xrotation
    End Site {
      OFFSET 0 2 0
    }
  }
}
MOTION
Frames: 2
Frame Time: .04
0 0 0 1 2 3 0
90 90 0 0 0 0 90
"""
    bvh = read_bvh(write(tmp_path, "x.bvh", text))
    assert bvh.names == ("a", "b c", "b c end")
    pos, quat = bvh.world()
    np.testing.assert_allclose(pos[0], [[1, 2, 3], [2, 2, 3], [2, 4, 3]], atol=1e-12)
    np.testing.assert_allclose(pos[1, 1], [0, 1, 0], atol=1e-12)
    # Rz(90) Rx(180) takes y to x.
    np.testing.assert_allclose(pos[1, 2], [2, 1, 0], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(quat, axis=-1), 1, atol=1e-12)


def test_bvh_agrees_with_pybvh(tmp_path):
    """Another reader finds the joints in the same places."""
    pybvh = pytest.importorskip("pybvh")
    path = write(tmp_path, "x.bvh", bvh_text(order="YXZ"))
    other = pybvh.read_bvh_file(path, world_up="+y")
    mine = read_bvh(path)
    theirs = other.node_positions()
    index = [other.node_index[name] for name in mine.names if not name.endswith(" end")]
    own = [i for i, name in enumerate(mine.names) if not name.endswith(" end")]
    np.testing.assert_allclose(mine.world()[0][:, own], theirs[:, index], atol=1e-6)


@pytest.mark.parametrize("joint", ["left_shoulder", "right_shoulder", "left_hip", "right_hip"])
def test_angles_within_finds_angles_inside_the_limits(joint):
    """Also where the y angle is beyond a quarter turn, which the plain extraction cannot give."""
    model = character()
    ranges = np.array([model.jnt_range[model.joint(f"{joint}_{axis}").id] for axis in "xyz"])
    rng = np.random.default_rng(0)
    targets = rng.uniform(ranges[:, 0], ranges[:, 1], (200, 3))
    quats = rotations.from_intrinsic_xyz(targets)
    for target, quat in zip(targets, quats, strict=True):
        found = angles_within(quat[None], joint)
        again = rotations.from_intrinsic_xyz(found)
        assert abs(np.sum(again * quat)) == pytest.approx(1, abs=1e-9)
        assert (found >= ranges[:, 0] - 1e-9).all() and (found <= ranges[:, 1] + 1e-9).all(), target


def test_sole_corners_are_those_of_the_boxes():
    qpos = np.zeros((1, 7 + len(joint_names())))
    qpos[:, 2:4] = (0.881416, 1)
    draft = from_poses(qpos)
    corners = sole_corners(draft.foot_pos, draft.foot_quat)
    np.testing.assert_allclose(corners[..., 2], 0, atol=1e-6)
    np.testing.assert_allclose(np.ptp(corners[0, 0], axis=0), [0.177, 0.09, 0], atol=1e-6)


def test_standing_is_low_and_slow():
    corners = np.zeros((30, 4, 3))
    corners[10:20, :, 2] = 0.1  # up in the air
    corners[20:, :, 0] = np.arange(10)[:, None] * 0.1  # down, at 3 m/s
    assert standing(corners)[:9].all() and not standing(corners)[10:].any()


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
