"""A view in the browser, with sliders: for machines without a display. Needs the optional package viser."""

import math
import time
from importlib import import_module
from typing import Any

import mujoco
import numpy as np

from adapt_envs.drawing.scene import RenderingError
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.simulation.worlds import Worlds
from adapt_envs.tasks.goal import GOAL_RADIUS
from sb3_adaptnet.play.controls import Controls

try:
    viser: Any = import_module("viser")
    trimesh: Any = import_module("trimesh")
except ImportError:
    viser = trimesh = None

_GROUND, _CELL = 30.0, 1.0
_GOAL_COLOUR = (41, 158, 90)
_FASTEST, _STRONGEST = 3.5, 1.5


class Browser:
    """Shows one world in every browser that opens its address; the character stays in the middle, the ground moves."""

    def __init__(self, worlds: Worlds, controls: Controls, host: str = "127.0.0.1", port: int = 8080) -> None:
        """Serve at `host` and `port` (or the next free port).

        Raises:
            RenderingError: if viser is not installed.
        """
        if viser is None:
            raise RenderingError(
                "the view in the browser needs the package viser: pip install viser (or adaptnet-gym[play])"
            )
        self._worlds, model = worlds, worlds.model
        self._data = mujoco.MjData(model)
        self._server = viser.ViserServer(host=host, port=port, verbose=False)
        self._open = True
        self.address = f"http://{host}:{self._server.get_port()}"
        self._bodies = [_add_body(self._server.scene, model, body) for body in range(1, model.nbody)]
        self._grid = self._server.scene.add_grid("/ground", width=_GROUND, height=_GROUND, cell_size=_CELL)
        disc = trimesh.creation.cylinder(GOAL_RADIUS, 0.02)
        self._target = _add_mesh(self._server.scene, "/goal", disc, _GOAL_COLOUR)
        self._server.initial_camera.position = (2.8, -3.6, 2.0)
        self._server.initial_camera.look_at = (0.0, 0.0, 0.85)
        self.sliders = _add_sliders(self._server.gui, controls)
        self._due = time.monotonic()

    @property
    def running(self) -> bool:
        """Whether it is open."""
        return self._open

    def show(self) -> None:
        """Send the first world's present state, waiting so that steps follow each other at 30 Hz."""
        worlds = self._worlds
        worlds.physics.mujoco_data(0, self._data)
        middle = np.array([*worlds.root_xy[0], 0.0])
        with self._server.atomic():
            for handle, position, quat in zip(self._bodies, self._data.xpos[1:], self._data.xquat[1:], strict=True):
                handle.position, handle.wxyz = position - middle, quat
            self._grid.position = -np.mod(middle, _CELL)
            self._target.position = np.array([*worlds.goals.target[0], 0.01]) - middle
        self._due = max(self._due + CONTROL_DT, time.monotonic())
        time.sleep(max(0.0, self._due - time.monotonic()))

    def close(self) -> None:
        """Stop serving."""
        self._open = False
        self._server.stop()


def _add_body(scene: Any, model: mujoco.MjModel, body: int) -> Any:
    """A frame with the meshes of one body's geoms; return its handle."""
    frame = scene.add_frame(f"/body_{body}", show_axes=False)
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    for geom in range(first, first + count):
        shape = _shape(model, geom)
        if shape is not None:
            colour = tuple(int(255 * value) for value in _rgb(model, geom))
            handle = _add_mesh(scene, f"/body_{body}/geom_{geom}", shape, colour)
            handle.position, handle.wxyz = model.geom_pos[geom], model.geom_quat[geom]
    return frame


def _add_mesh(scene: Any, name: str, shape: Any, colour: tuple[int, ...]) -> Any:
    return scene.add_mesh_simple(name, np.asarray(shape.vertices), np.asarray(shape.faces), color=colour)


def _shape(model: mujoco.MjModel, geom: int) -> Any:
    """Mesh of a geom in its own frame; None for kinds that bodies of this character do not have."""
    size, kind = model.geom_size[geom], model.geom_type[geom]
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return trimesh.creation.icosphere(radius=size[0])
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        return trimesh.creation.capsule(radius=size[0], height=2 * size[1])
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return trimesh.creation.cylinder(radius=size[0], height=2 * size[1])
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return trimesh.creation.box(extents=2 * size)
    return None


def _rgb(model: mujoco.MjModel, geom: int) -> np.ndarray:
    material = int(model.geom_matid[geom])
    return (model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])[:3]


def _add_sliders(gui: Any, controls: Controls) -> dict[str, Any]:
    """Sliders for speed, heading, alpha and blend, by name, that write into `controls`."""
    made = {
        "speed": gui.add_slider("speed [m/s]", min=0.1, max=_FASTEST, step=0.05, initial_value=controls.speed),
        "heading": gui.add_slider("heading [deg]", min=-180, max=180, step=5, initial_value=0),
        "random goals": gui.add_checkbox("random goals", initial_value=controls.random_goals),
        "restart": gui.add_button("restart"),
    }
    if controls.alpha is not None:
        alpha = min(max(controls.alpha, 0.0), _STRONGEST)
        made["alpha"] = gui.add_slider("alpha", min=0.0, max=_STRONGEST, step=0.05, initial_value=alpha)
    if len(controls.weights) > 1:
        for name, weight in controls.weights.items():
            value = min(max(weight, 0.0), 1.0)
            label = f"blend {controls.labels.get(name, name)}"
            made[f"blend {name}"] = gui.add_slider(label, min=0.0, max=1.0, step=0.05, initial_value=value)
    for name, handle in made.items():
        register = handle.on_click if name == "restart" else handle.on_update
        register(lambda event, name=name: take(controls, name, getattr(event.target, "value", True)))
    return made


def take(controls: Controls, name: str, value: Any) -> None:
    """Write a slider's value into the controls."""
    if name == "heading":
        controls.heading = math.radians(value)
    elif name == "random goals":
        controls.random_goals = bool(value)
    elif name == "restart":
        controls.restart = True
    elif name.startswith("blend "):
        controls.weights = {**controls.weights, name.removeprefix("blend "): float(value)}
    else:
        setattr(controls, name, float(value))
