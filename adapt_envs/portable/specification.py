"""What an observation is made of, and the rules of the worlds, as JSON values: one specification for all languages."""

from typing import Any

from adapt_envs.features.heading_frame import GOAL_SIZE, OBSERVATION_SIZE, OBSERVED_FRAMES
from adapt_envs.features.heightmap import AHEAD, ASIDE, SIZE
from adapt_envs.features.kinematics import LINK_STATE
from adapt_envs.model.build import FALL_PARTS, FALL_SENSOR
from adapt_envs.model.humanoid import CONTROL_DT, LINKS, PHYSICS_STEPS, joint_names
from adapt_envs.model.patch_grid import INSET
from adapt_envs.model.terrain import GRID
from adapt_envs.suite import SUITE, TaskSpec
from adapt_envs.tasks.goal import GOAL_RADIUS, NO_DIRECTION, SHARPNESS
from adapt_envs.tasks.push import PushSchedule

COMPONENTS = {
    "position": (0, 3, "m", "of the link frame's origin; height over the ground below the root"),
    "orientation": (3, 4, "", "quaternion w, x, y, z with w >= 0"),
    "velocity": (7, 3, "m/s", "of the link frame's origin, absolute"),
    "angular_velocity": (10, 3, "rad/s", "absolute"),
}
"""Parts of a link's state by name: offset, size, unit, words."""
GOAL = {
    "direction": (0, 2, "", "unit vector to the target, zero within `no_direction` of it"),
    "distance": (2, 1, "m", "horizontal, to the target"),
    "speed": (3, 1, "m/s", "preferred"),
}
"""Parts of the goal by name, likewise."""

BASE_ROWS = {"walk": "Walk", "run": "Run"}
"""Bases and the rows of the suite that they were trained in."""


def observation_specification() -> dict[str, Any]:
    """JSON values from which another program can build the observations that policies read.

    Number (frame x links + link) x link_size + offset of an observation is a component of a link's state in a frame,
    oldest first; the goal follows. All is in the heading frame of the last frame's root: origin on the ground below
    it, z up, x along its heading.
    """
    return {
        "version": 1,
        "size": OBSERVATION_SIZE,
        "frames": OBSERVED_FRAMES,
        "links": list(LINKS),
        "link_size": LINK_STATE,
        "link": _rows(COMPONENTS),
        "goal_offset": OBSERVATION_SIZE - GOAL_SIZE,
        "goal": _rows(GOAL),
        "heightmap": {"size": SIZE, "grid": GRID, "ahead": AHEAD, "aside": ASIDE},
        "joints": list(joint_names()),
        "control_hz": round(1 / CONTROL_DT),
        "physics_steps": PHYSICS_STEPS,
        "fall_sensors": {f"{FALL_SENSOR}_{part}": list(links) for part, links in FALL_PARTS.items()},
        "task": {
            "goal_radius": GOAL_RADIUS,
            "no_direction": NO_DIRECTION,
            "sharpness": SHARPNESS,
            "edge": INSET,
        },
        "bases": {base: _task(SUITE[row]) for base, row in BASE_ROWS.items()},
        "push": {"link": "torso", "force": PushSchedule().force, "seconds": PushSchedule().seconds},
    }


def _task(row: TaskSpec) -> dict[str, Any]:
    """Range of the preferred speed [m/s], and how far ahead a held goal lies [s]."""
    assert row.speed_range is not None
    return {"speeds": list(row.speed_range), "held_seconds": row.timer_range[1]}


def _rows(table: dict[str, tuple[int, int, str, str]]) -> dict[str, dict[str, Any]]:
    names = ("offset", "size", "unit", "words")
    return {name: dict(zip(names, row, strict=True)) for name, row in table.items()}
