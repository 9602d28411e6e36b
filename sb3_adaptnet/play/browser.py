"""A view in the browser, with sliders: for machines without a display. Needs the optional package viser."""

import socket
import time

import mujoco
import numpy as np

from adapt_envs.drawing.scene import RenderingError
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.simulation.worlds import Worlds
from sb3_adaptnet.play.controls import Controls
from sb3_adaptnet.play.extra import viser
from sb3_adaptnet.play.figure import Figure
from sb3_adaptnet.play.landscape import Landscape
from sb3_adaptnet.play.sliders import add_sliders

_CAMERA, _LOOK_AT = (2.8, -3.6, 2.0), (0.0, 0.0, 0.85)
"""Where the camera is and where it looks [m], as seen from the ground below the character."""


class Browser:
    """Shows one world in every browser that opens its address; the character stays in the middle, the ground moves.

    Attributes:
        address: where to open it.
        sliders: viser's handles of the controls, by name.
    """

    def __init__(self, worlds: Worlds, controls: Controls, host: str = "127.0.0.1", port: int = 8080) -> None:
        """Serve at `host` and `port` (or the next free port).

        Raises:
            RenderingError: if viser is not installed, or this machine cannot serve at `host`.
        """
        if viser is None:
            raise RenderingError(
                "the view in the browser needs the package viser: pip install viser (or adaptnet-gym[play])"
            )
        check_host(host)
        self._worlds = worlds
        self._data = mujoco.MjData(worlds.model)
        self._server = viser.ViserServer(host=host, port=port, verbose=False)
        self._open = True
        name = f"[{host}]" if ":" in host else host  # RFC 3986, 3.2.2
        self.address = f"http://{name}:{self._server.get_port()}"
        self._figure = Figure(self._server.scene, worlds.model)
        self._landscape = Landscape(self._server.scene, worlds.model, worlds.ground)
        self._server.initial_camera.position, self._server.initial_camera.look_at = _CAMERA, _LOOK_AT
        self.sliders = add_sliders(self._server.gui, controls)
        self._due = time.monotonic()

    @property
    def running(self) -> bool:
        """Whether it is open."""
        return self._open

    def show(self) -> None:
        """Send the first world's present state, waiting so that steps follow each other at 30 Hz."""
        worlds = self._worlds
        worlds.physics.mujoco_data(0, self._data)
        first = worlds.root_xy[:1]
        middle = np.append(first, worlds.ground.floor_at(first)).astype(np.float64)
        with self._server.atomic():
            self._figure.place(self._data, middle)
            self._landscape.place(middle, worlds.goals.target[0])
        self._due = max(self._due + CONTROL_DT, time.monotonic())
        time.sleep(max(0.0, self._due - time.monotonic()))

    def close(self) -> None:
        """Stop serving."""
        self._open = False
        self._server.stop()


def check_host(host: str) -> None:
    """Refuse an address that this machine does not have: viser would look for a free port there for ever.

    Raises:
        RenderingError: naming it.
    """
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        try:
            probe.bind((host, 0))
        except OSError as error:
            raise RenderingError(f"the view in the browser cannot be served at {host!r}: {error}") from error
