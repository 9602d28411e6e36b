"""Pictures of several clips beside each other: films, and strips of one pose from each."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.drawing.clip_scene import LOOK_HEIGHT
from adapt_envs.drawing.film import video_frames
from adapt_envs.drawing.picture import Image, text_band, tiled, write_png
from adapt_envs.drawing.scene import FRONT, SIDE, Camera, Scene
from adapt_envs.features import rotations
from adapt_envs.features.kinematics import Kinematics
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import LINKS
from adapt_envs.motion.clip import FPS, MotionClip
from sb3_adaptnet.evaluation.imitation_error import local_positions

_PANE = (432, 480)
_TILE = (230, 320)
_BAND, _FONT_SIZE = 32, 17
"""Height of a caption and size of its text [pixels]; with it a pane is a multiple of 16 high, as codecs like it."""
_RIGHT_FOOT, _LEFT_FOOT = LINKS.index("right_foot"), LINKS.index("left_foot")


def captioned(picture: Image, caption: str) -> Image:
    """The picture with a line of text above it."""
    return np.concatenate([text_band(caption, picture.shape[1], _BAND, _FONT_SIZE), picture])


def side_by_side(clips: Mapping[str, MotionClip], size: tuple[int, int] = _PANE) -> Iterator[Image]:
    """Pictures at 30 Hz of all clips at once, captioned by their keys, as long as the shortest lasts."""
    panes = [video_frames(clip, size) for clip in clips.values()]
    for pictures in zip(*panes, strict=False):
        parts = [captioned(picture, caption) for caption, picture in zip(clips, pictures, strict=True)]
        yield tiled([parts], len(parts))


def pose_strip(clips: Mapping[str, MotionClip], model: mujoco.MjModel | None = None) -> Image:
    """One pose of each clip, its longest step with the right foot ahead, from the side above from the front.

    Args:
        clips: caption -> clip.
        model: the character that the clips are of, on flat ground; the plain one if None.

    Returns:
        The picture (height, width, 3).
    """
    model = compile_model() if model is None else model
    kinematics = Kinematics(model)
    with Scene(model, *_TILE) as scene:
        columns = []
        for caption, clip in clips.items():
            pose = facing_x(clip.qpos, longest_step(kinematics, clip))
            tiles = [_tile(scene, pose, camera) for camera in (SIDE, FRONT)]
            columns.append(captioned(np.concatenate(tiles), caption))
    return tiled([columns], len(columns))


def write_strip(clips: Mapping[str, MotionClip], path: str | Path, model: mujoco.MjModel | None = None) -> None:
    """Write `pose_strip` as a PNG."""
    write_png(pose_strip(clips, model), path)


def longest_step(kinematics: Kinematics, clip: MotionClip) -> int:
    """Frame of the clip in which the right foot is farthest ahead of the left."""
    local = local_positions(kinematics.link_states(clip.qpos))
    return int((local[:, _RIGHT_FOOT, 0] - local[:, _LEFT_FOOT, 0]).argmax())


def facing_x(qpos: NDArray[np.float64], frame: int) -> NDArray[np.float64]:
    """Configuration of one frame of (T, nq), turned so that the mean heading of the second around it is along x."""
    yaw = rotations.heading(qpos[max(0, frame - FPS // 2) : frame + FPS // 2 + 1, 3:7])
    turn = rotations.from_yaw(np.asarray(-np.arctan2(np.sin(yaw).mean(), np.cos(yaw).mean())))
    pose = qpos[frame].copy()
    pose[:3] = rotations.rotate(turn, pose[:3])
    pose[3:7] = rotations.multiply(turn, pose[3:7])
    return pose


def _tile(scene: Scene, pose: NDArray[np.float64], camera: Camera) -> Image:
    return scene.picture(pose, camera, np.array([pose[0], pose[1], LOOK_HEIGHT]))
