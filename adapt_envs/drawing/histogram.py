"""Which speeds and turning rates a base motion covers, as a picture."""

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from adapt_envs.drawing.palette import BLUE, css
from adapt_envs.features import rotations
from adapt_envs.motion.clip import FPS, MotionClip

_STEP = 0.27
"""Width of the smoothing [s], about half a step: what is left is the course, not the sway."""


def course_rates(clip: MotionClip) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Speed [m/s] and turning rate [degrees/s], left positive, of a clip's course at each frame, (T,) each."""
    velocity = gaussian_filter1d(np.gradient(clip.qpos[:, :2], 1 / FPS, axis=0), _STEP * FPS, axis=0, mode="nearest")
    heading = np.unwrap(rotations.heading(clip.qpos[:, 3:7]))
    turning = gaussian_filter1d(np.gradient(heading, 1 / FPS), _STEP * FPS, mode="nearest")
    return np.linalg.norm(velocity, axis=1), np.degrees(turning)


def write_histogram(clip: MotionClip, path: str | Path) -> None:
    """Write a PNG with the histograms of a clip's speed and turning rate, and both against each other."""
    speed, turning = course_rates(clip)
    figure = Figure(figsize=(11, 3.2), dpi=100, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    slow, sharp, both = figure.subplots(1, 3)
    speeds, turns = np.linspace(0, speed.max() + 0.1, 41), np.linspace(-1, 1, 61) * (np.abs(turning).max() + 5)
    share = np.full(len(speed), 100 / len(speed))
    slow.hist(speed, bins=speeds, weights=share, color=css(BLUE))
    slow.set(xlabel="speed [m/s]", ylabel="share of frames [%]", title=f"{clip.name}, {clip.seconds:.0f} s")
    sharp.hist(turning, bins=turns, weights=share, color=css(BLUE), log=True)
    sharp.set(xlabel="turning rate [degrees/s], left positive", ylabel="share of frames [%]")
    both.hist2d(turning, speed, bins=(turns, speeds), cmap="Blues", norm="log")
    both.set(xlabel="turning rate [degrees/s]", ylabel="speed [m/s]")
    canvas.print_png(str(path))
