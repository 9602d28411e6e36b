"""A clip's path over the ground, and its speed and turning over time."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from adapt_envs.drawing.palette import BLUE, GREY, PAPER, RED, css
from adapt_envs.drawing.picture import Image
from adapt_envs.features import rotations
from adapt_envs.motion.clip import FPS, MotionClip

_HEIGHT, _DPI = 340, 100
"""Height [pixels], and pixels per inch, in which Matplotlib measures."""


def path_plot(clip: MotionClip, marked: tuple[int, int], width: int) -> Image:
    """Picture (340, width, 3): the root's path from above, its speed and its turning rate.

    Args:
        clip: any clip.
        marked: first and last frame of a stretch to draw in another colour.
        width: the picture's width in pixels.
    """
    figure = Figure(figsize=(width / _DPI, _HEIGHT / _DPI), dpi=_DPI, facecolor=css(PAPER), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    path, curves = figure.subplots(1, 2, width_ratios=(1, 2.2))
    stretch = slice(marked[0], marked[1] + 1)
    path.plot(*clip.qpos[:, :2].T, color=css(BLUE), lw=1)
    path.plot(*clip.qpos[stretch, :2].T, color=css(RED), lw=2.5)
    path.plot(*clip.qpos[0, :2], "o", color=css(BLUE), ms=5)
    path.set_aspect("equal", adjustable="datalim")
    path.set(xlabel="x [m]", ylabel="y [m]", title="path from above (dot: start)")
    _curves(curves, clip, stretch)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()


def _curves(axes: Axes, clip: MotionClip, stretch: slice) -> None:
    times = np.arange(len(clip.qpos)) / FPS
    smooth = np.ones(FPS // 2) / (FPS // 2)
    speed = np.convolve(np.linalg.norm(clip.qvel[:, :2], axis=1), smooth, mode="same")
    yaw = np.unwrap(rotations.heading(clip.qpos[:, 3:7]))
    turning = np.convolve(np.degrees(np.gradient(yaw)) * FPS, smooth, mode="same")
    axes.plot(times, speed, color=css(BLUE), lw=1)
    axes.axvspan(times[stretch][0], times[stretch][-1], color=css(RED), alpha=0.3)
    title = "speed (blue) and turning (grey); the stretch drawn above in red"
    axes.set(xlabel="time [s]", ylabel="speed [m/s]", xlim=(0, times[-1]), title=title)
    other = axes.twinx()
    other.plot(times, turning, color=css(GREY), lw=0.8)
    other.set_ylabel("turning [deg/s]")
