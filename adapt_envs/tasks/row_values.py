"""Values of an environment's row, each as it is kept, or refused with one sentence."""

import os
from collections.abc import Callable, Mapping
from dataclasses import fields
from numbers import Integral, Real
from typing import Any

from adapt_envs.model.morphology import Morphology
from adapt_envs.model.obstacles import ObstacleField
from adapt_envs.tasks.push import PushSchedule


def _motion(name: str, value: Any) -> str:
    if not isinstance(value, str | os.PathLike) or not os.fspath(value):
        raise ValueError(f"{name} is {value!r}, expected a clip's name or file")
    return str(os.fspath(value))


def _range(name: str, value: Any) -> tuple[float, float]:
    try:
        low, high = (float(number) for number in (() if isinstance(value, str) else value))
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}, expected two numbers") from None
    if not 0 < low <= high < float("inf"):
        raise ValueError(f"{name} is {value!r}, expected 0 < low <= high")
    return low, high


def _range_or_none(name: str, value: Any) -> tuple[float, float] | None:
    return None if value is None else _range(name, value)


def _positive(name: str, value: Any, expected: str = "a positive number") -> float:
    if isinstance(value, bool) or not isinstance(value, Real) or not 0 < float(value) < float("inf"):
        raise ValueError(f"{name} is {value!r}, expected {expected}")
    return float(value)


def _height(name: str, value: Any) -> float | None:
    return None if value is None else _positive(name, value, "a positive number of metres, or None")


def _seed(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral) or value < 0:
        raise ValueError(f"{name} is {value!r}, expected a whole number from 0")
    return int(value)


def _yes_or_no(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}, expected True or False")
    return value


def _joints(name: str, value: Any) -> tuple[str, ...]:
    joints = (value,) if isinstance(value, str) else value
    try:
        joints = tuple(joints)
    except TypeError:
        joints = (None,)
    if not all(isinstance(joint, str) for joint in joints):
        raise ValueError(f"{name} is {value!r}, expected names of joints, such as ('right_knee',)")
    return joints


def _made(kind: Any, name: str, value: Any) -> Any:
    """Make what a YAML file writes as a mapping, such as {force: 600.0}; other values stay as they are."""
    if not isinstance(value, Mapping):
        return value
    known = [field.name for field in fields(kind)]
    unknown = [key for key in value if key not in known]
    if unknown:
        raise ValueError(f"{name} has {unknown[0]!r}, expected {', '.join(known)}")
    try:
        return kind(**{key: tuple(part) if isinstance(part, list) else part for key, part in value.items()})
    except (TypeError, AttributeError):
        raise ValueError(f"{name} is {value!r}, expected values of {kind.__name__}") from None


def _named(kind: type, words: str) -> Callable[[str, Any], Any]:
    def check(name: str, value: Any) -> Any:
        value = _made(kind, name, value)
        if not (value is None or isinstance(value, str | kind)):
            raise ValueError(f"{name} is {value!r}, expected a name, {words}, or None")
        return value

    return check


def _terrain(name: str, value: Any) -> Any:
    if not (value is None or isinstance(value, str) or callable(value)):
        raise ValueError(f"{name} is {value!r}, expected a name, a function (rng, size) -> heights, or None")
    return value


def _push(name: str, value: Any) -> PushSchedule | None:
    value = _made(PushSchedule, name, value)
    if not (value is None or isinstance(value, PushSchedule)):
        raise ValueError(f"{name} is {value!r}, expected a PushSchedule(force, seconds, interval), or None")
    return value


CHECKS: dict[str, Callable[[str, Any], Any]] = {
    "motion": _motion,
    "speed_range": _range_or_none,
    "timer_range": _range,
    "friction": _positive,
    "morphology": _named(Morphology, "a Morphology"),
    "locked": _joints,
    "terrain": _terrain,
    "terrain_seed": _seed,
    "terrain_scale": _positive,
    "obstacles": _named(ObstacleField, "an ObstacleField"),
    "heightmap": _yes_or_no,
    "fall_height": _height,
    "push": _push,
    "clip_on_body": _yes_or_no,
}
"""Field of a row -> a function (name, value) that returns the value as it is kept, or raises ValueError."""
