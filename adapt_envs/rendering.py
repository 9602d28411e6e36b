"""Pictures and a window of a running world, with its goal drawn on the ground."""

import time
import warnings

import glfw
import mujoco
import mujoco.viewer
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.scene import Camera, Image, RenderingError, Scene
from adapt_envs.tasks.goal import GOAL_RADIUS
from adapt_envs.worlds import Worlds

PICTURE_SIZE = (640, 480)
"""Width and height [pixels] of `render()`'s pictures."""
_CAMERA = Camera(azimuth=120, elevation=-16, distance=6.5, fovy=30)
_LOOK_HEIGHT = 0.85
_GOAL_COLOUR = (0.16, 0.62, 0.35, 0.9)
_RING_SEGMENTS = 24
_IDENTITY = np.eye(3).ravel()


def draw_goal(scene: mujoco.MjvScene, root_xy: NDArray[np.floating], target: NDArray[np.floating], speed: float) -> None:
    """Add the goal to a scene: a ring of radius 0.5 m at the target and an arrow towards it, as long as the speed.

    Args:
        scene: the scene to add to.
        root_xy: (2,) root position [m], world.
        target: (2,) target [m], world.
        speed: preferred speed [m/s]; the arrow shows half a metre for each.
    """
    angles = np.linspace(0, 2 * np.pi, _RING_SEGMENTS + 1)
    ring = np.stack([*(target[:, None] + GOAL_RADIUS * np.stack([np.cos(angles), np.sin(angles)])), 0.02 + 0 * angles], 1)
    for start, end in zip(ring[:-1], ring[1:], strict=True):
        _connect(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, 0.02, start, end)
    offset = target - root_xy
    distance = float(np.linalg.norm(offset))
    if distance > GOAL_RADIUS:
        start = np.array([*(root_xy + 0.45 * offset / distance), 0.06])
        _connect(scene, mujoco.mjtGeom.mjGEOM_ARROW, 0.035, start, start + np.array([*(offset / distance), 0]) * speed / 2)


def _connect(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, width: float, start: NDArray[np.floating], end: NDArray[np.floating]
) -> None:
    if scene.ngeom >= scene.maxgeom:
        return
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), _IDENTITY, np.array(_GOAL_COLOUR, np.float32))
    mujoco.mjv_connector(geom, kind, width, np.asarray(start, float), np.asarray(end, float))
    scene.ngeom += 1


def _decorate(scene: mujoco.MjvScene, worlds: Worlds, world: int) -> None:
    goals = worlds.goals
    draw_goal(scene, worlds.root_xy[world], goals.target[world], float(goals.speed[world]))


class SceneRenderer:
    """Offscreen pictures of worlds, the camera following the character."""

    def __init__(self, model: mujoco.MjModel, size: tuple[int, int] = PICTURE_SIZE) -> None:
        """Open the renderer for `model`; `size` is width and height in pixels."""
        self._scene = Scene(model, *size)
        self._data = mujoco.MjData(model)

    def picture(self, worlds: Worlds, world: int = 0, camera: Camera = _CAMERA) -> Image:
        """The world's present state with its goal, (height, width, 3)."""
        worlds.physics.mujoco_data(world, self._data)
        lookat = np.array([*worlds.root_xy[world], _LOOK_HEIGHT])
        return self._scene.picture_of(self._data, camera, lookat, lambda scene: _decorate(scene, worlds, world))

    def close(self) -> None:
        """Give the renderer back."""
        self._scene.close()


class Window:
    """An interactive window that shows one world at real speed."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Open the window.

        Raises:
            RenderingError: if this machine has no display.
        """
        self._data = mujoco.MjData(model)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", glfw.GLFWError)
            shown = glfw.init()  # MuJoCo's viewer ends the whole process where this fails
        if not shown:
            raise RenderingError("cannot open a window, there is no display; use render_mode='rgb_array'")
        self._viewer = mujoco.viewer.launch_passive(model, self._data, show_left_ui=False, show_right_ui=False)
        self._viewer.cam.distance, self._viewer.cam.elevation = 5.0, -16
        self._due = time.monotonic()

    def show(self, worlds: Worlds, world: int = 0) -> None:
        """Draw the world's present state, waiting so that steps follow each other at 30 Hz."""
        with self._viewer.lock():
            worlds.physics.mujoco_data(world, self._data)
            self._viewer.cam.lookat[:] = (*worlds.root_xy[world], _LOOK_HEIGHT)
            self._viewer.user_scn.ngeom = 0
            _decorate(self._viewer.user_scn, worlds, world)
        self._viewer.sync()
        self._due = max(self._due + CONTROL_DT, time.monotonic())
        time.sleep(max(0.0, self._due - time.monotonic()))

    def close(self) -> None:
        """Close the window."""
        self._viewer.close()
