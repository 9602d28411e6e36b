"""Contact sheets and videos of motion clips: what to look at before trusting one."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import imageio.v2 as imageio
import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image as PilImage
from PIL import ImageDraw, ImageFont

from adapt_envs.drawing.path_plot import path_plot
from adapt_envs.drawing.scene import FRONT, QUARTER, SIDE, Camera, Image, Scene
from adapt_envs.features import rotations
from adapt_envs.model.build import compile_model
from adapt_envs.motion.clip import FPS, MotionClip, MotionError

POSES = 8
"""Pictures in a row of a sheet."""
_TILE = (230, 320)
_GAP, _HEADER, _CAPTION = 3, 58, 24
_LONG = 4.0
"""Clips that last longer [s] get a stretch picked from them, and a plot of their path."""
_STRETCH = 1.2
"""Length [s] of that stretch: about one cycle of walking."""
_LOOK_HEIGHT = 0.90
"""Height of the cameras' aim above the ground [m]: the middle of the standing character."""
_INK, _SOFT, _PAPER = (32, 38, 48), (104, 112, 124), (250, 250, 248)
_VIDEO_SIZE = (720, 720)


def contact_sheet(clip: MotionClip, poses: int = POSES) -> Image:
    """Draw a clip: a row from the side above a row from the front, `poses` moments evenly in time.

    A cyclic or short clip is drawn from end to end; of a long one its most typical 1.2 s, with the path it takes.

    Args:
        clip: a clip of the plain character.
        poses: moments to draw.

    Returns:
        The picture (height, width, 3).

    Raises:
        MotionError: if the clip is for a character with other joints.
        RenderingError: if this machine cannot draw.
    """
    first, last = typical_stretch(clip)
    count = last - first + (0 if clip.cyclic else 1)
    frames = first + np.unique(np.round(np.linspace(0, count, poses, endpoint=not clip.cyclic)).astype(int))
    frames = np.minimum(frames, last)
    model = _model_for(clip)
    with Scene(model, *_TILE) as scene:
        rows = [[_tile(scene, clip, int(frame), camera) for frame in frames] for camera in (SIDE, FRONT)]
    parts = [_header(clip, poses), *(_row(row, poses) for row in rows), _captions(frames / FPS, poses)]
    if clip.seconds > _LONG:
        parts.append(path_plot(clip, (first, last), _width(poses)))
    return np.concatenate(parts, axis=0)


def write_sheet(clip: MotionClip, path: str | Path) -> None:
    """Write the clip's contact sheet as a PNG (see `contact_sheet`)."""
    PilImage.fromarray(contact_sheet(clip)).save(path, format="PNG", optimize=True)


def video_frames(clip: MotionClip, size: tuple[int, int] = _VIDEO_SIZE, min_seconds: float = 5.0) -> Iterable[Image]:
    """Pictures of a clip at 30 Hz, the camera following; a cyclic clip repeats until `min_seconds` are full."""
    model = _model_for(clip)
    count = len(clip.qpos)
    if clip.cyclic:
        count = clip.period * max(1, int(np.ceil(min_seconds * FPS / clip.period)))
    configurations = clip.at(np.arange(count))
    lookats = _followed(configurations[:, :2])
    with Scene(model, *size) as scene:
        for qpos, lookat in zip(configurations, lookats, strict=True):
            yield scene.picture(qpos, QUARTER, lookat)


def write_video(clip: MotionClip, path: str | Path, frames: Iterable[Image] | None = None) -> None:
    """Write a video of the clip at 30 frames per second.

    Args:
        clip: a clip of the plain character.
        path: an `.mp4` or `.gif` file.
        frames: the pictures, where they are not simply `video_frames(clip)` (a progress bar around them, say).
    """
    with imageio.get_writer(path, fps=FPS) as writer:
        for picture in video_frames(clip) if frames is None else frames:
            writer.append_data(picture)  # type: ignore[attr-defined]


def typical_stretch(clip: MotionClip) -> tuple[int, int]:
    """First and last frame of what a sheet draws: all of a short or cyclic clip, else the most typical 1.2 s.

    Typical is the window whose speed and turning lie nearest the medians of the whole clip, in units of their spread.
    """
    if clip.cyclic or clip.seconds <= _LONG:
        return 0, len(clip.qpos) - 1
    window = int(_STRETCH * FPS)
    step = np.linalg.norm(np.diff(clip.qpos[:, :2], axis=0), axis=1)
    turn = np.abs(np.diff(np.unwrap(rotations.heading(clip.qpos[:, 3:7]))))
    kernel = np.ones(window) / window
    features = np.stack([np.convolve(values, kernel, mode="valid") for values in (step, turn)], axis=1)
    spread = np.maximum(features.std(axis=0), 1e-9)
    first = int(np.abs((features - np.median(features, axis=0)) / spread).sum(axis=1).argmin())
    return first, first + window


def _model_for(clip: MotionClip) -> mujoco.MjModel:
    model = compile_model()
    names = tuple(model.actuator(i).name for i in range(model.nu))
    if clip.joint_names != names:
        odd = sorted(set(names) ^ set(clip.joint_names)) or ["their order"]
        raise MotionError(f"clip {clip.name!r} does not fit the character; they differ in: {', '.join(odd)}")
    return model


def _tile(scene: Scene, clip: MotionClip, frame: int, camera: Camera) -> Image:
    """One pose, placed at the origin facing x so that every tile is seen from the same side under the same light."""
    middle = clip.at([frame])[0].copy()
    yaw = _course(clip, frame)
    turn = rotations.from_yaw(np.asarray(-yaw))
    middle[3:7] = rotations.multiply(turn, middle[3:7])
    # The ground keeps moving under the character: its checker shows how far it went.
    middle[:3] = rotations.rotate(turn, middle[:3])
    return scene.picture(middle, camera, np.array([middle[0], middle[1], _LOOK_HEIGHT]))


def _course(clip: MotionClip, frame: int) -> float:
    """Mean heading [rad] of the half second on either side: the character's own swing of the hips stays visible."""
    quats = clip.at(np.arange(frame - FPS // 2, frame + FPS // 2 + 1))[:, 3:7]
    yaw = rotations.heading(quats)
    return float(np.arctan2(np.sin(yaw).mean(), np.cos(yaw).mean()))


def _followed(points: NDArray[np.floating], seconds: float = 0.5) -> NDArray[np.float64]:
    """Aim (T, 3) of a camera that follows ground points (T, 2) smoothly."""
    width = 2 * int(seconds * FPS) + 1
    kernel = np.hanning(width + 2)[1:-1]
    half = width // 2
    steps = np.diff(points, axis=0)
    # The path goes on straight beyond its ends, so that the camera does not lag there.
    before = points[0] + steps[:1] * np.arange(-half, 0)[:, None]
    after = points[-1] + steps[-1:] * np.arange(1, half + 1)[:, None]
    edges = np.concatenate([before, points, after])
    smooth = np.stack([np.convolve(edges[:, i], kernel / kernel.sum(), mode="valid") for i in (0, 1)], axis=1)
    return np.concatenate([smooth, np.full((len(points), 1), _LOOK_HEIGHT)], axis=1)


def _width(poses: int) -> int:
    return poses * (_TILE[0] + _GAP) + _GAP


def _row(tiles: Sequence[Image], poses: int) -> Image:
    canvas = np.full((_TILE[1] + _GAP, _width(poses), 3), _PAPER, np.uint8)
    for i, tile in enumerate(tiles):
        left = _GAP + i * (_TILE[0] + _GAP)
        canvas[: _TILE[1], left : left + _TILE[0]] = tile
    return canvas


def _header(clip: MotionClip, poses: int) -> Image:
    canvas = PilImage.new("RGB", (_width(poses), _HEADER), _PAPER)
    draw = ImageDraw.Draw(canvas)
    title = ImageFont.load_default(30)
    draw.text((14, 12), clip.name, _INK, font=title)
    kind = "one cycle" if clip.cyclic else "clip"
    facts = f"{kind} of {clip.seconds:.2f} s, {clip.mean_speed:.2f} m/s"
    if abs(np.degrees(clip.cycle_transform[0])) > 1 and clip.cyclic:
        facts += f", turns {np.degrees(clip.cycle_transform[0]):.0f} deg"
    draw.text((14 + draw.textlength(clip.name, font=title) + 22, 22), facts, _SOFT, font=ImageFont.load_default(19))
    note = "right is red, left is blue"
    font = ImageFont.load_default(15)
    draw.text((_width(poses) - draw.textlength(note, font=font) - 14, 25), note, _SOFT, font=font)
    return np.asarray(canvas)


def _captions(times: NDArray[np.floating], poses: int) -> Image:
    canvas = PilImage.new("RGB", (_width(poses), _CAPTION), _PAPER)
    draw = ImageDraw.Draw(canvas)
    font = ImageFont.load_default(15)
    for i, time in enumerate(times):
        text = f"{time:.2f} s"
        middle = _GAP + i * (_TILE[0] + _GAP) + _TILE[0] / 2
        draw.text((middle - draw.textlength(text, font=font) / 2, 1), text, _SOFT, font=font)
    return np.asarray(canvas)
