"""Contact sheets of motion clips: what to look at before trusting one."""

from pathlib import Path

import mujoco
import numpy as np

from adapt_envs.drawing.clip_scene import LOOK_HEIGHT, clip_scene
from adapt_envs.drawing.palette import SOFT
from adapt_envs.drawing.path_plot import path_plot
from adapt_envs.drawing.picture import Image, blank, text_band, text_width, tiled, write_png, write_text
from adapt_envs.drawing.scene import FRONT, SIDE, Camera, Scene
from adapt_envs.features import rotations
from adapt_envs.motion.clip import FPS, MotionClip

POSES = 8
"""Pictures in a row of a sheet."""
_TILE = (230, 320)
"""Width and height [pixels] of a picture."""
_GAP, _HEADER, _CAPTION = 3, 55, 18
"""Space between pictures, and heights of the lines above and below them [pixels]."""
_TITLE_SIZE, _FACTS_SIZE, _NOTE_SIZE = 30, 19, 15
"""Sizes of text [pixels]."""
_TITLE_LEFT, _BASELINE = 14, 36
"""Where the header's text begins, and the row on which it stands [pixels]."""
_LONG = 4.0
"""Clips that last longer [s] get a stretch picked from them, and a plot of their path."""
_STRETCH = 1.2
"""Length [s] of that stretch: about one cycle of walking."""


def contact_sheet(clip: MotionClip, poses: int = POSES, model: mujoco.MjModel | None = None) -> Image:
    """Draw a clip: a row from the side above a row from the front, `poses` moments evenly in time.

    A cyclic or short clip is drawn from end to end; of a long one its most typical 1.2 s, with the path it takes.

    Args:
        clip: any clip.
        poses: moments to draw.
        model: the character that the clip is of, on flat ground; the plain one if None.

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
    with clip_scene(clip, *_TILE, model) as scene:
        rows = [[_tile(scene, clip, int(frame), camera) for frame in frames] for camera in (SIDE, FRONT)]
    captions = [text_band(f"{frame / FPS:.2f} s", _TILE[0], _CAPTION, _NOTE_SIZE, SOFT) for frame in frames]
    pictures = tiled(rows, poses, _GAP)
    width = pictures.shape[1]
    parts = [_header(clip, width), pictures, tiled([captions], poses, _GAP)]
    if clip.seconds > _LONG:
        parts.append(path_plot(clip, (first, last), width))
    return np.concatenate(parts, axis=0)


def write_sheet(clip: MotionClip, path: str | Path, model: mujoco.MjModel | None = None) -> None:
    """Write the clip's contact sheet as a PNG (see `contact_sheet`)."""
    write_png(contact_sheet(clip, model=model), path)


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


def _tile(scene: Scene, clip: MotionClip, frame: int, camera: Camera) -> Image:
    """One pose, placed at the origin facing x so that every tile is seen from the same side under the same light."""
    middle = clip.at([frame])[0].copy()
    yaw = _course(clip, frame)
    turn = rotations.from_yaw(np.asarray(-yaw))
    middle[3:7] = rotations.multiply(turn, middle[3:7])
    # The ground keeps moving under the character: its checker shows how far it went.
    middle[:3] = rotations.rotate(turn, middle[:3])
    return scene.picture(middle, camera, np.array([middle[0], middle[1], LOOK_HEIGHT]))


def _course(clip: MotionClip, frame: int) -> float:
    """Mean heading [rad] of the half second on either side: the character's own swing of the hips stays visible."""
    quats = clip.at(np.arange(frame - FPS // 2, frame + FPS // 2 + 1))[:, 3:7]
    yaw = rotations.heading(quats)
    return float(np.arctan2(np.sin(yaw).mean(), np.cos(yaw).mean()))


def _header(clip: MotionClip, width: int) -> Image:
    header = blank(width, _HEADER)
    write_text(header, clip.name, _TITLE_LEFT, _BASELINE, _TITLE_SIZE)
    kind = "one cycle" if clip.cyclic else "clip"
    facts = f"{kind} of {clip.seconds:.2f} s, {clip.mean_speed:.2f} m/s"
    if abs(np.degrees(clip.cycle_transform[0])) > 1 and clip.cyclic:
        facts += f", turns {np.degrees(clip.cycle_transform[0]):.0f} deg"
    after = _TITLE_LEFT + text_width(clip.name, _TITLE_SIZE) + 22
    write_text(header, facts, after, _BASELINE, _FACTS_SIZE, SOFT)
    note = "right is red, left is blue"
    write_text(header, note, width - text_width(note, _NOTE_SIZE) - _TITLE_LEFT, _BASELINE, _NOTE_SIZE, SOFT)
    return header
