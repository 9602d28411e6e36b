"""Films of motion clips and of rollouts, and how pictures become a video file."""

from collections.abc import Iterable, Iterator
from contextlib import closing
from itertools import chain
from pathlib import Path
from typing import Any

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from adapt_envs.drawing.clip_scene import LOOK_HEIGHT, clip_scene
from adapt_envs.drawing.picture import Image
from adapt_envs.drawing.scene import QUARTER
from adapt_envs.drawing.world_view import HIGH, SceneRenderer
from adapt_envs.motion.clip import FPS, MotionClip
from adapt_envs.motion.whole_file import whole_file
from adapt_envs.simulation.worlds import Worlds

VIDEO_SIZE = (720, 720)
"""Width and height [pixels] of a film."""
_ENCODINGS: dict[str, dict[str, Any]] = {
    ".mp4": {},
    # A palette for every picture: nothing has to wait in memory for the film's end.
    ".gif": {
        "codec": "gif", "pix_fmt_out": "pal8",
        "output_params": [
            "-filter_complex", "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=dither=none:new=1",
        ],
    },
}  # fmt: skip
"""What FFmpeg is told for a file's extension, beyond H.264. OpenCV's wheels cannot encode that, which every browser
plays; their VP9 took 10 times as long for 5 times the bytes."""


def video_frames(clip: MotionClip, size: tuple[int, int] = VIDEO_SIZE, min_seconds: float = 5.0) -> Iterator[Image]:
    """Pictures of a clip at 30 Hz, the camera following; a cyclic clip repeats until `min_seconds` are full.

    Args:
        clip: a clip of the plain character.
        size: width and height [pixels]; video codecs like multiples of 16.
        min_seconds: least length of a cyclic clip's film [s].

    Raises:
        MotionError: if the clip is for a character with other joints.
        RenderingError: if this machine cannot draw.
    """
    count = len(clip.qpos)
    if clip.cyclic:
        count = clip.period * max(1, int(np.ceil(min_seconds * FPS / clip.period)))
    configurations = clip.at(np.arange(count))
    lookats = _followed(configurations[:, :3] * (1, 1, 0))
    with clip_scene(clip, *size) as scene:
        for qpos, lookat in zip(configurations, lookats, strict=True):
            yield scene.picture(qpos, QUARTER, lookat)


def rollout_frames(worlds: Worlds, qpos: NDArray[np.float64], size: tuple[int, int] = VIDEO_SIZE) -> Iterator[Image]:
    """Pictures at 30 Hz of the worlds' own character on their own ground, the camera following.

    Args:
        worlds: whose body, locks and ground are drawn; their state does not matter and stays.
        qpos: (T, nq) configurations, world frame, one every 1/30 s.
        size: width and height [pixels]; video codecs like multiples of 16.

    Raises:
        RenderingError: if this machine cannot draw.
    """
    roots = qpos[:, :2]
    lookats = _followed(np.column_stack([roots, worlds.ground.floor_at(roots)]))
    camera = QUARTER if worlds.ground.obstacles is None else HIGH
    with closing(SceneRenderer(worlds, size)) as renderer:
        for configuration, lookat in zip(qpos, lookats, strict=True):
            yield renderer.picture_at(configuration, camera, lookat)


def write_video(frames: Iterable[Image], path: str | Path) -> None:
    """Write pictures as a video at 30 frames per second, whole or not at all.

    Args:
        frames: pictures of one size.
        path: an `.mp4` file (H.264, which every browser plays) or a `.gif` file.

    Raises:
        ValueError: if there are no pictures, or the file is of another kind.
        OSError: if the file cannot be written.
    """
    encoding = _ENCODINGS.get(Path(path).suffix.lower())
    if encoding is None:
        raise ValueError(f"{str(path)!r} is no video; the extension must be one of {', '.join(_ENCODINGS)}")
    pictures = iter(frames)
    first = next(pictures, None)
    if first is None:
        raise ValueError(f"there are no pictures for {str(path)!r}")
    size = (first.shape[1], first.shape[0])
    # Without a quality FFmpeg takes the codec's own.
    settings = {"fps": FPS, "quality": None, "ffmpeg_log_level": "error", **encoding}
    with whole_file(Path(path)) as part, closing(imageio_ffmpeg.write_frames(str(part), size, **settings)) as encoder:
        encoder.send(None)  # starts it
        for picture in chain([first], pictures):
            encoder.send(np.ascontiguousarray(picture))


def _followed(points: NDArray[np.floating], seconds: float = 0.5) -> NDArray[np.float64]:
    """Aim (T, 3) of a camera that follows points of the ground (T, 3) smoothly."""
    width = 2 * int(seconds * FPS) + 1
    kernel = np.hanning(width + 2)[1:-1]
    half = width // 2
    steps = np.diff(points, axis=0) if len(points) > 1 else np.zeros_like(points)
    # The path goes on straight beyond its ends, so that the camera does not lag there.
    before = points[0] + steps[:1] * np.arange(-half, 0)[:, None]
    after = points[-1] + steps[-1:] * np.arange(1, half + 1)[:, None]
    edges = np.concatenate([before, points, after])
    smooth = np.stack([np.convolve(edges[:, i], kernel / kernel.sum(), mode="valid") for i in range(3)], axis=1)
    return smooth + (0, 0, LOOK_HEIGHT)
