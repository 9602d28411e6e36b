"""Motion clips: looping, mirroring, velocities, files."""

import json

import numpy as np
import pytest

from adapt_envs.features import rotations
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import compile_model
from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.library import load_clip, reference_motion

MODEL = compile_model()
JOINTS = tuple(MODEL.actuator(i).name for i in range(MODEL.nu))


def turning_clip(frames=30):
    """A cycle that walks along an arc: 0.5 m ahead and 0.4 rad to the left in a period."""
    phase = np.arange(frames + 1) / frames
    yaw = 0.4 * phase
    qpos = np.zeros((frames + 1, 35))
    radius = 0.5 / 0.4
    qpos[:, 0], qpos[:, 1] = radius * np.sin(yaw) + 2, radius * (1 - np.cos(yaw)) - 1
    qpos[:, 2] = 0.88 + 0.02 * np.sin(4 * np.pi * phase)
    qpos[:, 3:7] = rotations.from_yaw(yaw)
    qpos[:, 7:] = 0.1 * np.sin(2 * np.pi * phase[:, None] + np.arange(28))
    return MotionClip("arc", qpos, JOINTS, cyclic=True)


def test_a_cycle_goes_on_smoothly_in_both_directions():
    clip = turning_clip()
    assert clip.period == 30
    frames = np.arange(-65, 96)
    qpos = clip.at(frames)
    radius = 0.5 / 0.4
    yaw = 0.4 * frames / 30
    assert np.allclose(qpos[:, 0], radius * np.sin(yaw) + 2, atol=1e-9)
    assert np.allclose(qpos[:, 1], radius * (1 - np.cos(yaw)) - 1, atol=1e-9)
    assert np.allclose(rotations.heading(qpos[:, 3:7]), (yaw + np.pi) % (2 * np.pi) - np.pi, atol=1e-9)


def test_velocities_are_those_of_the_arc():
    qvel = turning_clip().qvel
    assert np.allclose(np.linalg.norm(qvel[:, :2], axis=1), 0.5, rtol=1e-3)
    assert np.allclose(qvel[:, 5], 0.4, rtol=1e-3)
    assert np.allclose(qvel[:, 6], 0.1 * 2 * np.pi * np.cos(2 * np.pi * np.arange(31) / 30), atol=5e-3)


def test_mirroring_twice_is_the_identity_and_once_reflects_the_links():
    clip = turning_clip()
    assert np.allclose(clip.mirrored().mirrored().qpos, clip.qpos)

    kinematics = Kinematics(MODEL)
    plain, mirrored = kinematics.link_states(clip.qpos), kinematics.link_states(clip.mirrored().qpos)
    swap = [0, 1, 2, 6, 7, 8, 3, 4, 5, 12, 13, 14, 9, 10, 11]
    assert np.allclose(mirrored[:, swap, :3], plain[..., :3] * (1, -1, 1), atol=1e-5)


def test_save_and_load_keep_everything(tmp_path):
    clip = turning_clip()
    clip.save(tmp_path / "arc.npz")
    again = MotionClip.load(tmp_path / "arc.npz")
    assert np.allclose(again.qpos, clip.qpos, atol=1e-6)
    assert (again.name, again.joint_names, again.cyclic) == (clip.name, clip.joint_names, clip.cyclic)
    assert again.digest == MotionClip.load(tmp_path / "arc.npz").digest
    assert list(tmp_path.iterdir()) == [tmp_path / "arc.npz"]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda q: q[:, :-1], r"qpos has shape \(31, 34\), expected \(frames, 35\)"),
        (lambda q: q[:3], "3 frames, at least 6 are needed"),
        (lambda q: np.where(np.arange(31)[:, None] == 7, np.nan, q), "frame 7 holds a number that is not finite"),
        (lambda q: q * 2, "frame 0 has a root quaternion of length 2.000"),
    ],
)
def test_unusable_motions_are_refused(spoil, message):
    with pytest.raises(MotionError, match=message):
        MotionClip("bad", spoil(turning_clip().qpos), JOINTS)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04cut", b"\0" * 4096, b"hello"])
def test_foreign_files_get_one_sentence(tmp_path, content):
    path = tmp_path / "x.npz"
    path.write_bytes(content)
    with pytest.raises(MotionError, match="not a motion clip"):
        MotionClip.load(path)
    with pytest.raises(MotionError, match="no such file"):
        MotionClip.load(tmp_path / "missing.npz")


@pytest.mark.parametrize("name", ["walk.bvh", "walk.json"])
def test_a_recording_is_to_be_imported_first(tmp_path, name):
    (tmp_path / name).write_text("HIERARCHY")
    with pytest.raises(MotionError, match=f"a recording; import it first: adaptnet motions import {name} -o NAME.npz"):
        load_clip(str(tmp_path / name))


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"fps": 60}, "60 frames a second, expected 30"),
        ({"name": 5}, "name, origin and joints must be text"),
        ({"format": "other-1"}, "format 'other-1', expected"),
    ],
)
def test_what_a_file_says_of_itself_is_checked(tmp_path, changes, message):
    file = tmp_path / "mine.npz"
    load_clip("Stoop").save(file)
    with np.load(file) as data:
        qpos, meta = data["qpos"], json.loads(str(data["meta"]))
    np.savez(file, qpos=qpos, meta=np.array(json.dumps(meta | changes)))
    with pytest.raises(MotionError, match=message):
        MotionClip.load(file)
    qpos[:, 3:7] *= 3
    np.savez(file, qpos=qpos, meta=np.array(json.dumps(meta)))
    with pytest.raises(MotionError, match="has a root quaternion of length 3.000"):
        MotionClip.load(file)


def test_joints_in_another_order_are_put_in_order_and_others_are_named(tmp_path):
    stoop, file = load_clip("Stoop"), tmp_path / "mine.npz"
    order = np.random.default_rng(0).permutation(len(stoop.joint_names))
    names = tuple(stoop.joint_names[i] for i in order)
    MotionClip("mine", stoop.qpos[:, [*range(7), *(7 + order)]], names, True).save(file)
    assert load_clip(str(file)).digest == stoop.digest
    MotionClip("mine", stoop.qpos[:, :-1], stoop.joint_names[:-1], True).save(file)
    with pytest.raises(MotionError, match="does not fit the character; they differ in: left_ankle_z"):
        load_clip(str(file))


def test_a_clip_file_that_changed_is_read_again(tmp_path):
    file = tmp_path / "mine.npz"
    for name in ("Stoop", "Limp"):
        load_clip(name).save(file)
        assert load_clip(str(file)).digest == load_clip(name).digest
        assert reference_motion(str(file)).clips[0].digest == load_clip(name).digest
    assert load_clip(str(file)) is load_clip(str(file))
