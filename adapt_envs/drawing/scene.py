"""Pictures of configurations: an offscreen renderer with a camera that is set by hand."""

import atexit
import os
import weakref
from collections.abc import Callable
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.drawing import headless
from adapt_envs.drawing.picture import Image


class RenderingError(OSError):
    """No picture can be drawn on this machine as it is; the message says what is missing."""


@dataclass(frozen=True)
class Camera:
    """A camera that looks at a point.

    Attributes:
        azimuth: direction of view about z in degrees: 0 looks along x, 90 along y.
        elevation: direction of view above the horizon in degrees; negative looks down.
        distance: distance from the point [m].
        fovy: vertical field of view in degrees; a narrow one far away draws near to true proportions.
    """

    azimuth: float = 90.0
    elevation: float = -10.0
    distance: float = 6.0
    fovy: float = 21.0


SIDE = Camera(azimuth=90)
"""From the right of a character that faces x."""
FRONT = Camera(azimuth=180)
"""From ahead of a character that faces x."""
QUARTER = Camera(azimuth=140, elevation=-14, distance=7.5, fovy=24)
"""From ahead on the right, a little above: for videos."""


class Scene:
    """Draws a model offscreen. Use as a context manager, or call `close`."""

    def __init__(self, model: mujoco.MjModel, width: int, height: int) -> None:
        """Open the renderer.

        Args:
            model: what to draw; its offscreen buffer is enlarged where it is too small.
            width: pictures' width in pixels.
            height: pictures' height in pixels.

        Raises:
            RenderingError: if OpenGL cannot be reached.
        """
        self.model, self.data = model, mujoco.MjData(model)
        limits = model.vis.global_
        limits.offwidth, limits.offheight = max(limits.offwidth, width), max(limits.offheight, height)
        try:
            self._renderer: mujoco.Renderer | None = mujoco.Renderer(model, height, width)
        except Exception as error:  # every backend raises another kind
            raise RenderingError(_no_opengl(error)) from None
        # Closed before OpenGL's own exit handler runs, or it complains on the way out.
        atexit.register(_close, weakref.ref(self))

    def picture(self, qpos: NDArray[np.floating], camera: Camera, lookat: NDArray[np.floating]) -> Image:
        """The model in configuration `qpos` (nq,), seen by `camera` that looks at `lookat` (3,) [m, world frame]."""
        self.data.qpos[:] = qpos
        mujoco.mj_forward(self.model, self.data)
        return self.picture_of(self.data, camera, lookat)

    def picture_of(
        self, data: mujoco.MjData, camera: Camera, lookat: NDArray[np.floating],
        decorate: Callable[[mujoco.MjvScene], None] | None = None,
    ) -> Image:  # fmt: skip
        """The state `data`, whose kinematics are current, seen by `camera` that looks at `lookat` (3,) [m].

        `decorate` may add geoms to the scene before it is drawn.
        """
        if self._renderer is None:
            raise RenderingError("this scene is closed")
        self.model.vis.global_.fovy = camera.fovy
        self._renderer.update_scene(data, view(camera, lookat))
        if decorate is not None:
            decorate(self._renderer.scene)
        return self._renderer.render()

    def close(self) -> None:
        """Give the renderer back; a second call does nothing."""
        if self._renderer is not None:
            self._renderer.render()  # MuJoCo frees in the current context, which may have been another scene's
            self._renderer.close()
        self._renderer = None

    def __enter__(self) -> "Scene":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def view(camera: Camera, lookat: NDArray[np.floating]) -> mujoco.MjvCamera:
    """MuJoCo's free camera that stands as `camera` says and looks at `lookat` (3,) [m, world frame]."""
    free = mujoco.MjvCamera()
    free.type = mujoco.mjtCamera.mjCAMERA_FREE
    free.lookat[:] = lookat
    free.azimuth, free.elevation, free.distance = camera.azimuth, camera.elevation, camera.distance
    return free


def _close(scene: "weakref.ref[Scene]") -> None:
    alive = scene()
    if alive is not None:
        alive.close()


def _no_opengl(error: Exception) -> str:
    asked = f"{headless.GL_VARIABLE}={os.environ.get(headless.GL_VARIABLE, '')}"
    return (
        f"cannot open an offscreen OpenGL context with {asked!r} ({error}); on a machine without a display set"
        f" {headless.GL_VARIABLE}=egl (Debian packages libegl1 libgl1-mesa-dri) or {headless.GL_VARIABLE}=osmesa"
        " (Debian package libosmesa6) before Python starts"
    )
