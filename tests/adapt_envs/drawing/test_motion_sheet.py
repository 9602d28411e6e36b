"""Contact sheets: what is drawn, where, and what happens where nothing can be drawn."""

import cv2
import mujoco
import numpy as np
import pytest

from adapt_envs.drawing import scene
from adapt_envs.drawing.headless import backend
from adapt_envs.drawing.motion_sheet import contact_sheet, typical_stretch, write_sheet
from adapt_envs.features import rotations
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion.clip import MotionClip, MotionError, transformed

RED = np.array([1.0, -0.5, -0.5])


def walk(frames: int = 31, speed: float = 1.0, yaw: float = 0.0, cyclic: bool = True) -> MotionClip:
    """A stiff figure that glides along a line while its arms swing once."""
    qpos = np.zeros((frames, 7 + len(joint_names())))
    qpos[:, 0] = np.arange(frames) * speed / 30
    qpos[:, 2:4] = (0.881416, 1)
    swing = np.sin(np.linspace(0, 2 * np.pi, frames))
    qpos[:, 7 + joint_names().index("right_shoulder_y")] = -0.8 * swing
    qpos[:, 7 + joint_names().index("left_shoulder_y")] = 0.8 * swing
    return MotionClip("Glide", transformed(qpos, yaw, np.array([3.0, -2.0])), joint_names(), cyclic)


@pytest.fixture(scope="module")
def drawn() -> np.ndarray:
    """The sheet of the straight glide."""
    return contact_sheet(walk())


def tiles(sheet: np.ndarray, poses: int = 8) -> list[np.ndarray]:
    """The pictures of the upper row."""
    return [sheet[60:370, 5 + i * 233 : 230 + i * 233].astype(float) for i in range(poses)]


def centre(tile: np.ndarray, colour: np.ndarray) -> float:
    """Mean column of the pixels that lean to a colour."""
    strength = (tile - tile.mean(axis=2, keepdims=True)) @ colour
    columns = np.nonzero(strength > 60)[1]
    assert len(columns) > 50
    return float(columns.mean())


def test_every_pose_is_in_the_middle_of_its_tile(drawn):
    assert drawn.dtype == np.uint8 and drawn.shape == (58 + 2 * 323 + 24, 8 * 233 + 3, 3)
    for tile in tiles(drawn):
        assert abs(centre(tile, RED) - 112) < 25


def test_the_side_view_is_the_side_whatever_the_heading(drawn):
    """The nearest limbs are the right, red ones, and the swing of the arms looks the same."""
    for one, other in zip(tiles(drawn), tiles(contact_sheet(walk(yaw=2.5))), strict=True):
        assert centre(one, RED) == pytest.approx(centre(other, RED), abs=3)
    # At a quarter of the cycle the red arm is ahead, which is to the right from the right.
    assert centre(tiles(drawn)[2], RED) > centre(tiles(drawn)[6], RED) + 5


def test_poses_of_a_cycle_are_evenly_spread_and_do_not_repeat_the_first(drawn):
    sheet = tiles(drawn)
    assert abs(centre(sheet[1], RED) - centre(sheet[3], RED)) < 4  # sin(pi/4) = sin(3 pi/4)
    assert abs(centre(sheet[0], RED) - centre(sheet[7], RED)) > 1.5


def test_a_long_clip_gets_its_path():
    short, long = (contact_sheet(walk(frames, cyclic=False), poses=2) for frames in (61, 200))
    assert len(long) > len(short) + 200


def test_the_typical_stretch_is_the_one_that_moves_like_most_of_the_clip():
    clip = walk(400, cyclic=False)
    qpos = clip.qpos.copy()
    speed = np.full(400, 1.0)
    speed[:100], speed[350:] = 0.0, 3.0
    qpos[:, 0] = np.cumsum(speed) / 30
    first, last = typical_stretch(MotionClip("x", qpos, joint_names()))
    assert first >= 100 and last < 351 and last - first == 36
    assert typical_stretch(walk()) == (0, 30)


def test_a_clip_of_another_character_is_refused():
    clip = walk()
    with pytest.raises(MotionError, match="left_ankle_z"):
        contact_sheet(MotionClip("x", clip.qpos[:, :-1], clip.joint_names[:-1]))


def test_the_file_holds_what_was_drawn(drawn, tmp_path):
    write_sheet(walk(), tmp_path / "sheet.png")
    read = cv2.cvtColor(cv2.imread(str(tmp_path / "sheet.png")), cv2.COLOR_BGR2RGB)
    np.testing.assert_array_equal(read, drawn)


def test_the_camera_looks_where_it_is_told():
    camera = scene.view(scene.Camera(azimuth=30, elevation=-20, distance=4), np.array([1.0, 2, 3]))
    assert (camera.azimuth, camera.elevation, camera.distance) == (30, -20, 4)
    np.testing.assert_array_equal(camera.lookat, [1, 2, 3])


def test_without_opengl_one_sentence_says_what_to_do(monkeypatch):
    def broken(*_: object) -> None:
        raise RuntimeError("no EGL here")

    monkeypatch.setattr(mujoco, "Renderer", broken)
    with pytest.raises(scene.RenderingError, match="no EGL here.*MUJOCO_GL=egl.*libegl1 libgl1-mesa-dri.*libosmesa6"):
        scene.Scene(compile_model(), 64, 64)


def test_a_closed_scene_says_so():
    with scene.Scene(compile_model(), 64, 64) as small:
        qpos = np.concatenate([[0, 0, 0.88], rotations.from_yaw(np.asarray(0.0)), np.zeros(28)])
        assert small.picture(qpos, scene.SIDE, np.zeros(3)).shape == (64, 64, 3)
    with pytest.raises(scene.RenderingError, match="closed"):
        small.picture(qpos, scene.SIDE, np.zeros(3))
    small.close()


def test_the_backend_is_chosen_only_where_nothing_else_is():
    assert backend({"DISPLAY": ":0"}, "linux") is None
    assert backend({"MUJOCO_GL": "osmesa"}, "linux") is None
    assert backend({}, "darwin") is None
    assert backend({}, "linux") in {"egl", "osmesa", None}
