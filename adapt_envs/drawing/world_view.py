"""Pictures and a window of a running world, with its goal drawn on the ground."""

import time
import warnings
from collections.abc import Callable

import glfw
import mujoco
import mujoco.viewer
import numpy as np
from numpy.typing import NDArray

from adapt_envs.drawing.palette import GOAL, PUSH
from adapt_envs.drawing.picture import Image
from adapt_envs.drawing.scene import Camera, RenderingError, Scene
from adapt_envs.model.ground import Ground
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.simulation.worlds import Worlds
from adapt_envs.tasks.goal import GOAL_RADIUS

PICTURE_SIZE = (640, 480)
"""Width and height [pixels] of `render()`'s pictures."""
CAMERA = Camera(azimuth=120, elevation=-16, distance=6.5, fovy=30)
"""The view of `render()`'s pictures."""
HIGH = Camera(azimuth=120, elevation=-36, distance=7.0, fovy=34)
"""The same among obstacles: from above, over the blocks."""
_LOOK_HEIGHT = 0.85
_RING_SEGMENTS = 24
_PUSH_LENGTH = 0.9
"""Length [m] of the arrow of a push of 1000 N."""
_RECUT = 4.0
"""A new piece of terrain is drawn when the character is this far [m] from the middle of the last one."""
_IDENTITY = np.eye(3).ravel()

Array = NDArray[np.floating]


def draw_goal(scene: mujoco.MjvScene, ground: Ground, root_xy: Array, target: Array, speed: float) -> None:
    """Add the goal to a scene: a ring of radius 0.5 m at the target and an arrow towards it, as long as the speed.

    Args:
        scene: the scene to add to.
        ground: what the ring lies on.
        root_xy: (2,) root position [m], world.
        target: (2,) target [m], world.
        speed: preferred speed [m/s]; the arrow shows half a metre for each.
    """
    angles = np.linspace(0, 2 * np.pi, _RING_SEGMENTS + 1)
    ring = _on(ground, target + GOAL_RADIUS * np.stack([np.cos(angles), np.sin(angles)], axis=-1), 0.02)
    for start, end in zip(ring[:-1], ring[1:], strict=True):
        _connect(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, 0.02, start, end, GOAL)
    offset = target - root_xy
    distance = float(np.linalg.norm(offset))
    if distance > GOAL_RADIUS:
        along = offset / distance
        start, end = _on(ground, np.stack([root_xy + 0.45 * along, root_xy + (0.45 + speed / 2) * along]), 0.06)
        _connect(scene, mujoco.mjtGeom.mjGEOM_ARROW, 0.035, start, end, GOAL)


def draw_push(scene: mujoco.MjvScene, torso: Array, force: Array) -> None:
    """Add the arrow of a push to a scene; it ends at the torso.

    Args:
        scene: the scene to add to.
        torso: (3,) where the force acts [m], world.
        force: (3,) the force [N], world; nothing is drawn for zero.
    """
    if np.any(force):
        strength = np.linalg.norm(force)
        end = torso - 0.13 * force / strength
        start = end - _PUSH_LENGTH / 1000 * force
        _connect(scene, mujoco.mjtGeom.mjGEOM_ARROW, 0.05, start, end, PUSH)


def _on(ground: Ground, xy: Array, above: float) -> Array:
    """Points (n, 3) that lie `above` [m] the ground at (n, 2)."""
    return np.column_stack([xy, ground.floor_at(xy) + above])


def _connect(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, width: float, start: Array, end: Array, colour: tuple[float, ...]
) -> None:
    if scene.ngeom >= scene.maxgeom:
        return
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, np.zeros(3), np.zeros(3), _IDENTITY, np.array(colour, np.float32))
    mujoco.mjv_connector(geom, kind, width, np.asarray(start, float), np.asarray(end, float))
    scene.ngeom += 1


def _decorate(scene: mujoco.MjvScene, data: mujoco.MjData, worlds: Worlds, world: int) -> None:
    goals = worlds.goals
    draw_goal(scene, worlds.ground, worlds.root_xy[world], goals.target[world], float(goals.speed[world]))
    if worlds.pushes is not None:
        draw_push(scene, data.body("torso").xipos, worlds.pushes.force[world])


def _look_at(worlds: Worlds, world: int) -> NDArray[np.float64]:
    """(3,) where cameras look: the middle of the standing character."""
    return _on(worlds.ground, worlds.root_xy[world][None], _LOOK_HEIGHT)[0].astype(np.float64)


class SceneRenderer:
    """Offscreen pictures of worlds, the camera following the character."""

    def __init__(self, worlds: Worlds, size: tuple[int, int] = PICTURE_SIZE) -> None:
        """Open the renderer for `worlds`; `size` is width and height in pixels."""
        self._worlds, self._size = worlds, size
        self._scenes: dict[int, tuple[Scene, Array]] = {}  # by world, with the middle of its piece of ground

    def picture(self, world: int = 0, camera: Camera | None = None) -> Image:
        """The world's present state with its goal, (height, width, 3); the camera suits the ground if None.

        Raises:
            RenderingError: if this machine cannot draw.
        """
        worlds = self._worlds
        scene = self._scene_around(worlds.root_xy[world], world)
        data = worlds.physics.mujoco_data(world, scene.data, scene.model)
        camera = camera or (CAMERA if worlds.ground.obstacles is None else HIGH)
        lookat = _look_at(worlds, world)
        return scene.picture_of(data, camera, lookat, lambda drawn: _decorate(drawn, data, worlds, world))

    def picture_at(self, qpos: Array, camera: Camera, lookat: Array) -> Image:
        """The character in a configuration (nq,) on the worlds' ground, without a goal, (height, width, 3).

        Args:
            qpos: (nq,) configuration, world frame.
            camera: how it is seen.
            lookat: (3,) where the camera looks [m], world frame.

        Raises:
            RenderingError: if this machine cannot draw.
        """
        return self._scene_around(qpos[:2]).picture(qpos, camera, lookat)

    def _scene_around(self, xy: Array, world: int = 0) -> Scene:
        """The scene of all worlds; on uneven ground that of one, with only the piece around `xy` (2,) [m] in it."""
        uneven = self._worlds.ground.surface is not None
        number = world if uneven else 0
        scene, middle = self._scenes.get(number, (None, xy))
        if scene is not None and uneven and np.abs(xy - middle).max() > _RECUT:
            self._scenes.pop(number)
            scene.close()
            scene = None
        if scene is None:
            model = self._worlds.compiled(self._worlds.ground.for_pictures(xy)) if uneven else self._worlds.model
            scene = Scene(model, *self._size)
            self._scenes[number] = scene, np.array(xy)
        return scene

    def close(self) -> None:
        """Give the renderer back."""
        for scene, _ in self._scenes.values():
            scene.close()
        self._scenes.clear()


class Window:
    """An interactive window that shows one world at real speed."""

    def __init__(self, worlds: Worlds, on_key: Callable[[int], None] | None = None) -> None:
        """Open the window; `on_key` is called with the GLFW code of every key that is pressed.

        Raises:
            RenderingError: if this machine has no display.
        """
        self._worlds = worlds
        uneven = worlds.ground.surface is not None
        self._model = worlds.compiled(worlds.ground.for_pictures()) if uneven else worlds.model
        self._data = mujoco.MjData(self._model)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", glfw.GLFWError)
            shown = glfw.init()  # MuJoCo's viewer ends the whole process where this fails
        if not shown:
            raise RenderingError("cannot open a window, there is no display; use render_mode='rgb_array'")
        self._viewer = mujoco.viewer.launch_passive(
            self._model, self._data, key_callback=on_key, show_left_ui=False, show_right_ui=False
        )
        self._viewer.cam.distance, self._viewer.cam.elevation = 5.0, -16
        self._due = time.monotonic()

    @property
    def running(self) -> bool:
        """Whether nobody has closed the window."""
        return self._viewer.is_running()

    def show(self, world: int = 0) -> None:
        """Draw the world's present state, waiting so that steps follow each other at 30 Hz."""
        worlds = self._worlds
        with self._viewer.lock():
            worlds.physics.mujoco_data(world, self._data, self._model)
            self._viewer.cam.lookat[:] = _look_at(worlds, world)
            self._viewer.user_scn.ngeom = 0
            _decorate(self._viewer.user_scn, self._data, worlds, world)
        self._viewer.sync()
        self._due = max(self._due + CONTROL_DT, time.monotonic())
        time.sleep(max(0.0, self._due - time.monotonic()))

    def close(self) -> None:
        """Close the window."""
        self._viewer.close()
