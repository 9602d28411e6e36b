"""The contact sheet of every environment: one picture each, under its id."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from adapt_envs.drawing.picture import Image, text_band, tiled, write_png
from adapt_envs.drawing.scene import Camera
from adapt_envs.drawing.world_view import HIGH, SceneRenderer
from adapt_envs.registration import env_id
from adapt_envs.simulation.worlds import Worlds
from adapt_envs.suite import find

COLUMNS = 6
"""Pictures in a row."""
_TILE = (300, 270)
"""Width and height [pixels] of a picture."""
_CAPTION, _FONT_SIZE, _GAP = 28, 12, 4
"""Height of the line below a picture, size of its text, and space between pictures [pixels]."""
_STEPS = 4
"""Steps from the start state to the picture: the character has come into motion."""
_CAMERA = Camera(azimuth=125, elevation=-14, distance=5.2, fovy=28)


def snapshot(name: str, size: tuple[int, int] = _TILE, seed: int = 2) -> Image:
    """A picture (height, width, 3) of the environment called `name`, a moment after a reset; a push acts if it has any.

    Raises:
        RenderingError: if this machine cannot draw.
    """
    spec = find(name)
    if spec.push is not None:  # soon, before the character that only holds its pose falls
        spec = replace(spec, push=replace(spec.push, interval=(spec.push.seconds, spec.push.seconds)))
    worlds = Worlds(spec, num_worlds=1, num_threads=1)
    worlds.rng = np.random.default_rng(seed)
    renderer = SceneRenderer(worlds, size)
    try:
        _advance(worlds)
        return renderer.picture(camera=_CAMERA if worlds.ground.obstacles is None else HIGH)
    finally:
        renderer.close()


def _advance(worlds: Worlds) -> None:
    worlds.reset(np.zeros(1, np.int64))
    action = worlds.reference.mean_pose[None]
    for _ in range(_STEPS):
        worlds.step(action, None)
    while worlds.pushes is not None and not worlds.pushes.force.any():
        worlds.step(action, None)


def gallery(names: Sequence[str], pictures: Iterable[Image], columns: int = COLUMNS) -> Image:
    """Put pictures (height, width, 3) of one size into rows, each above its environment's id."""
    tiles = [_captioned(name, picture) for name, picture in zip(names, pictures, strict=True)]
    return tiled([tiles[first : first + columns] for first in range(0, len(tiles), columns)], columns, _GAP)


def write_gallery(path: str | Path, names: Sequence[str], pictures: Iterable[Image]) -> None:
    """Write the contact sheet of the environments `names` as a PNG."""
    write_png(gallery(names, pictures), path)


def _captioned(name: str, picture: Image) -> Image:
    return np.concatenate([picture, text_band(env_id(name), picture.shape[1], _CAPTION, _FONT_SIZE)])
