"""Pictures: scenes, running worlds, films, and what is composed of them.

Contact sheets are `motion_sheet`'s. They are not imported here: they need Matplotlib, whose import takes as long as
that of all of `adapt_envs`.
"""

from adapt_envs.drawing import headless as headless  # first: it chooses OpenGL's backend before MuJoCo is imported
from adapt_envs.drawing.clip_scene import clip_scene
from adapt_envs.drawing.film import rollout_frames, video_frames, write_video
from adapt_envs.drawing.picture import Image, text_band, tiled, write_png
from adapt_envs.drawing.scene import FRONT, QUARTER, SIDE, Camera, RenderingError, Scene
from adapt_envs.drawing.world_view import SceneRenderer, Window

__all__ = [
    "FRONT", "QUARTER", "SIDE", "Camera", "Image", "RenderingError", "Scene", "SceneRenderer", "Window", "clip_scene",
    "rollout_frames", "text_band", "tiled", "video_frames", "write_png", "write_video",
]  # fmt: skip
