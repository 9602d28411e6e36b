"""A character as motion clips move it."""

import mujoco

from adapt_envs.drawing.scene import Scene
from adapt_envs.model.build import compile_model
from adapt_envs.model.humanoid import joints_of
from adapt_envs.motion.clip import MotionClip, MotionError

LOOK_HEIGHT = 0.90
"""Height [m] above the ground at which cameras aim: the middle of the standing character."""


def clip_scene(clip: MotionClip, width: int, height: int, model: mujoco.MjModel | None = None) -> Scene:
    """A scene, pictures `width` x `height` pixels, that draws the configurations of `clip`.

    Args:
        clip: any clip.
        width: pictures' width in pixels.
        height: pictures' height in pixels.
        model: the character that the clip is of, on flat ground; the plain one if None.

    Raises:
        MotionError: if the clip is for a character with other joints.
        RenderingError: if this machine cannot draw.
    """
    model = compile_model() if model is None else model
    names = joints_of(model)
    if clip.joint_names != names:
        odd = sorted(set(names) ^ set(clip.joint_names)) or ["their order"]
        raise MotionError(f"clip {clip.name!r} does not fit the character; they differ in: {', '.join(odd)}")
    return Scene(model, width, height)
