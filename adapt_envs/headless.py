"""How MuJoCo reaches OpenGL on a machine without a display; imported before `mujoco`, which decides once, at import."""

import ctypes.util
import os
import sys

GL_VARIABLE = "MUJOCO_GL"
"""Environment variable that names MuJoCo's way to OpenGL: egl, osmesa or glfw."""
_BACKENDS = (("egl", "EGL"), ("osmesa", "OSMesa"))


def backend(environment: dict[str, str] | None = None, platform: str = sys.platform) -> str | None:
    """The offscreen backend to ask for, or None where MuJoCo's own choice (or the user's) should stand.

    Args:
        environment: variables to look at; the process's if None.
        platform: as `sys.platform`.
    """
    environment = dict(os.environ) if environment is None else environment
    shown = any(environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", GL_VARIABLE))
    if shown or not platform.startswith("linux"):
        return None
    return next((name for name, library in _BACKENDS if ctypes.util.find_library(library)), None)


_chosen = backend()
if _chosen is not None:
    os.environ[GL_VARIABLE] = _chosen
