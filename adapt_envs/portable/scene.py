"""A character on a ground as JSON values: its MJCF, the numbers that the text rounds, and its start states."""

import re
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.features import rotations
from adapt_envs.features.heading_frame import OBSERVED_FRAMES
from adapt_envs.model.build import assemble, build_character
from adapt_envs.model.humanoid import joints_of
from adapt_envs.model.morphology import MORPHOLOGIES
from adapt_envs.motion.library import BASES, reference_motion
from adapt_envs.portable.choices import BODIES, LOCKS
from adapt_envs.portable.grounds import SiteGround, site_ground
from adapt_envs.simulation.spawn import spawned
from adapt_envs.tables import entry

START = 40
"""Number of the start state of each base's motion: a moment in mid-step."""
_IRRELEVANT = ("light_", "cam_", "mat_", "tex_", "bvh_", "hfield_data")
"""Beginnings of the names of model fields that physics does not read, or that are sent apart."""


def portable_scene(body: str, lock: str, ground: str) -> dict[str, Any]:
    """A character on a ground, which another MuJoCo can rebuild to the last bit.

    Args:
        body: name in `BODIES`.
        lock: name in `LOCKS`.
        ground: name in `GROUNDS`.

    Returns:
        JSON values: `mjcf`, text whose numbers have six digits, without the heights of uneven ground; `joints`, those
        with a servo, in order; `exact`, field of the compiled model -> its values as a flat list, where the text's
        differ, and `timestep`; `starts`, motion of a base -> `qpos`, `qvel`, `heading` [rad] and `history`,
        (4 x 15 x 13) link states up to this moment, world frame.

    Raises:
        ValueError: for a name that is not there, listing those that are.
    """
    shape_row, lock_row = entry("body", BODIES, body).row, entry("lock", LOCKS, lock).row
    shape = entry("morphology", MORPHOLOGIES, shape_row.morphology)
    place = site_ground(ground)
    spec = assemble(build_character(shape, lock_row.locked), place.friction, place.ground)
    model = spec.compile()
    text = _text(spec)
    starts = {base: _start(base, model, shape, lock_row.locked, place) for base in BASES}
    joints = list(joints_of(model))
    return {"mjcf": text, "joints": joints, "exact": _rounded_away(model, text), "starts": starts}


def _text(spec: mujoco.MjSpec) -> str:
    """MJCF of a compiled spec, without heights."""
    return re.sub(r' elevation="[^"]*"', "", spec.to_xml())


def _rounded_away(model: mujoco.MjModel, text: str) -> dict[str, Any]:
    """Fields of `model` that differ in the model that the text gives."""
    rebuilt = mujoco.MjModel.from_xml_string(text)
    exact: dict[str, Any] = {"timestep": model.opt.timestep}
    for name in dir(model):
        mine, theirs = (getattr(m, name, None) for m in (model, rebuilt))
        if (
            name.startswith(("_", *_IRRELEVANT))
            or not isinstance(mine, np.ndarray)
            or not isinstance(theirs, np.ndarray)
        ):
            continue
        if mine.shape != theirs.shape or (mine.dtype.kind != "f" and not np.array_equal(mine, theirs)):
            raise ValueError(f"the MJCF of this character gives another {name!r}")
        if not np.array_equal(mine, theirs):
            exact[name] = mine.ravel().tolist()
    return exact


def _start(base: str, model: mujoco.MjModel, shape: Any, locked: tuple[str, ...], place: SiteGround) -> dict[str, Any]:
    """The start state of a base's motion, put where characters start on this ground."""
    qpos, qvel, history = reference_motion(base, shape, locked).states(np.array([START]))
    x, y, heading = place.spawn
    if place.ground.plain:
        heading = 0.0
    xy = np.array([[x, y]])
    qpos, qvel, history = spawned(model, place.ground, qpos, qvel, history, xy, np.array([heading]))
    facing = float(rotations.heading(qpos[0, 3:7]))
    return {
        "qpos": qpos[0].tolist(), "qvel": qvel[0].tolist(), "heading": facing,
        "history": _short(history[0, -OBSERVED_FRAMES:]),
    }  # fmt: skip


def _short(values: NDArray[np.float32]) -> list[float]:
    """Float32 numbers as the shortest decimals that stand for them."""
    return [float(str(value)) for value in values.ravel()]
