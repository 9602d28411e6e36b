"""A film and a picture of a policy in its own world: its body, its ground, its goals."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from adapt_envs import AdaptVectorEnv
from adapt_envs.drawing.film import write_video
from adapt_envs.drawing.picture import Image, tiled, write_png
from adapt_envs.drawing.scene import Camera
from adapt_envs.drawing.world_view import HIGH, SceneRenderer
from adapt_envs.model.humanoid import CONTROL_DT
from sb3_adaptnet.evaluation.pictures import before_after
from sb3_adaptnet.evaluation.recording import Acting
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy

SECONDS = 10.0
"""Length of the film [s]."""
_SIZE, _TILE = (480, 480), (270, 270)
"""Width and height [pixels] of the film and of a tile of the picture."""
_TILES = 7
_CLOSE = Camera(azimuth=120, elevation=-14, distance=5.6, fovy=26)


def world_frames(
    policy: Acting, env: AdaptVectorEnv, seconds: float = SECONDS, seed: int = 0, every: int = 1
) -> Iterator[Image]:
    """Pictures of world 0 as it comes, falls and restarts included: the policy's mean action, random goals.

    Args:
        policy: acts on observations of all worlds.
        env: worlds without a time limit (`open_worlds`).
        seconds: how long it goes on.
        seed: of start states and goals.
        every: control steps (1/30 s) from a picture to the next.

    Raises:
        RenderingError: if this machine cannot draw.
    """
    renderer = SceneRenderer(env.worlds, _SIZE)
    camera = _CLOSE if env.worlds.ground.obstacles is None else HIGH
    try:
        env.set_goal(None, None)
        observations, _ = env.reset(seed=seed)
        for step in range(round(seconds / CONTROL_DT)):
            if step % every == 0:
                yield renderer.picture(0, camera)
            actions, _ = policy.predict(observations, deterministic=True)
            observations, *_ = env.step(actions)
    finally:
        renderer.close()


def write_film(policy: Acting, env: AdaptVectorEnv, path: Path, seconds: float = SECONDS, seed: int = 0) -> None:
    """Write `world_frames` as a video."""
    write_video(world_frames(policy, env, seconds, seed), path)


def write_picture(policy: Acting, env: AdaptVectorEnv, path: Path, seed: int = 0) -> None:
    """Write an adaptation beneath its base in the same world, or of any other policy seven moments of six seconds."""
    if isinstance(policy, AdaptNetPolicy):
        write_png(before_after(policy, env, seed), path)
        return
    every = round(6.0 / CONTROL_DT / _TILES)
    moments = world_frames(policy, env, _TILES * every * CONTROL_DT, seed, every)
    tiles = [np.asarray(cv2.resize(moment, _TILE, interpolation=cv2.INTER_AREA), np.uint8) for moment in moments]
    write_png(tiled([tiles], _TILES), path)
