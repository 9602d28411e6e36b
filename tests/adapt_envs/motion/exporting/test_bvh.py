"""BVH files: this project's own reader and importer, and another library, find the motion in them again."""

from dataclasses import replace

import numpy as np
import pytest

from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import build_character, compile_model, plain_model
from adapt_envs.model.humanoid import LINKS
from adapt_envs.model.morphology import MORPHOLOGIES
from adapt_envs.motion import load_clip
from adapt_envs.motion.exporting import perform, write_bvh
from adapt_envs.motion.exporting.performance import BONES
from adapt_envs.motion.importing import import_motion
from adapt_envs.motion.importing.bvh import read_bvh
from adapt_envs.motion.importing.foreign_body import is_own
from adapt_envs.motion.importing.skeletons import recognise

FRAMES = 90


def places(model, qpos):
    """(T, 15, 3) of the links [m], from where the root begins."""
    return Kinematics(model).link_states(qpos)[..., :3] - np.array([*qpos[0, :2], 0])


def z_up(points):
    """Points (..., 3) of a file as the simulation has them [m]."""
    return points[..., [2, 0, 1]] / 100


def written(tmp_path, model, qpos):
    file = tmp_path / "out.bvh"
    write_bvh(perform(model, qpos, 30.0), file)
    return file


@pytest.mark.parametrize("shape", [None, "super_long_legs"])
def test_the_reader_finds_every_joint_where_it_was(tmp_path, shape):
    model = compile_model(build_character(MORPHOLOGIES[shape] if shape else None))
    qpos = load_clip("Kicking").at(np.arange(FRAMES))
    bvh = read_bvh(written(tmp_path, model, qpos))
    bones = [bvh.names.index(BONES[link]) for link in LINKS]
    assert np.abs(z_up(bvh.world()[0][:, bones]) - places(model, qpos)).max() < 1e-5
    assert 1 / bvh.frame_time == pytest.approx(30, abs=1e-4)


def test_another_library_finds_them_too(tmp_path):
    qpos = load_clip("Stoop").at(np.arange(20))
    pybvh = pytest.importorskip("pybvh")
    bvh = pybvh.read_bvh_file(written(tmp_path, plain_model(), qpos), world_up="+y")
    bones = [bvh.node_index[BONES[link]] for link in LINKS]
    assert np.abs(z_up(bvh.node_positions()[:, bones]) - places(plain_model(), qpos)).max() < 1e-5


@pytest.mark.parametrize("clip", ["walk", "run", "Kicking"])
def test_the_importer_brings_every_joint_back(tmp_path, clip):
    """Also where feet drag and sink in and limits give way, as in rollouts: what the character did needs no repair."""
    model = plain_model()
    qpos = load_clip(clip).at(np.arange(FRAMES))
    qpos[:, 2] -= 0.015
    for joint in ("left_hip_x", "right_knee"):
        qpos[30:35, model.joint(joint).qposadr[0]] = model.joint(joint).range[0] - 0.04
    back = import_motion(written(tmp_path, model, qpos))
    assert len(back.qpos) == FRAMES
    assert np.linalg.norm(places(model, back.qpos) - places(model, qpos), axis=-1).max() < 1e-4


def test_what_no_character_can_do_is_repaired(tmp_path):
    model = plain_model()
    knee = model.joint("right_knee")
    qpos = load_clip("Stoop").qpos[:8].copy()
    qpos[3, knee.qposadr[0]] = knee.range[1] + 0.4
    back = import_motion(written(tmp_path, model, qpos)).qpos[:, knee.qposadr[0]]
    assert back.max() <= knee.range[1]


def test_a_skeleton_is_the_characters_own_in_any_unit_but_not_of_any_shape(tmp_path):
    file = written(tmp_path, plain_model(), load_clip("Stoop").qpos)
    bvh = read_bvh(file)
    joints = recognise(file, bvh.names)
    assert is_own(bvh, joints) and is_own(replace(bvh, offsets=bvh.offsets / 100), joints)
    longer = np.where(np.array(bvh.names) == "LeftLeg", 1.02, 1.0)[:, None]
    assert not is_own(replace(bvh, offsets=bvh.offsets * longer), joints)
    handless = {role: name for role, name in joints.joints.items() if role != "right_wrist"}
    assert not is_own(bvh, replace(joints, joints=handless))


def test_angles_go_on_where_they_pass_half_a_turn(tmp_path):
    qpos = np.tile(load_clip("Stoop").qpos[:1], (40, 1))
    yaw = np.linspace(0, 4 * np.pi, 40)
    qpos[:, 3:7] = np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=1)
    lines = written(tmp_path, plain_model(), qpos).read_text().splitlines()[-40:]
    turns = np.array([[float(word) for word in line.split()[3:6]] for line in lines])
    assert np.abs(np.diff(turns, axis=0)).max() < 20 and np.ptp(turns[:, 0]) == pytest.approx(720, abs=0.01)


def test_nothing_is_half_written(tmp_path):
    (tmp_path / "out.bvh").mkdir()
    with pytest.raises(OSError):
        written(tmp_path, plain_model(), load_clip("Stoop").qpos)
    assert [file.name for file in tmp_path.iterdir()] == ["out.bvh"]
