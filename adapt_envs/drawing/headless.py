"""How MuJoCo reaches OpenGL on a machine without a display.

MuJoCo chooses once, when it is imported. Where that was before this module's import, its choice is replaced.
"""

import ctypes.util
import importlib
import os
import sys

GL_VARIABLE = "MUJOCO_GL"
"""Environment variable that names MuJoCo's way to OpenGL: egl, osmesa or glfw."""
_BACKENDS = (("egl", "EGL"), ("osmesa", "OSMesa"))
_MUJOCO_DECIDES = "mujoco.rendering.classic.gl_context"


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


def choose() -> None:
    """Set MUJOCO_GL where nothing else says how to draw, and tell a MuJoCo that is imported already."""
    chosen = backend()
    if chosen is None:
        return
    os.environ[GL_VARIABLE] = chosen
    decided = sys.modules.get(_MUJOCO_DECIDES)
    if decided is not None:
        context = importlib.import_module(f"mujoco.{chosen}").GLContext
        decided.GLContext = context  # type: ignore[attr-defined]  # a module knows no such name before MuJoCo sets it


choose()
