"""Numbers that may change with the samples seen: one number, or points that are joined by straight lines."""

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

Schedule = float | Mapping[int, float]
"""A number, or samples -> number, such as `{0: 0.5, 1_000_000: 0.2}`; constant outside them."""


def value_at(points: Schedule, samples: int) -> float:
    """The number after `samples` samples."""
    if not isinstance(points, Mapping):
        return float(points)
    at = sorted(points)
    return float(np.interp(samples, at, [points[sample] for sample in at]))


def times_of(points: Schedule) -> list[int]:
    """The numbers of samples where lines meet, ascending; 0 of a number."""
    return sorted(points) if isinstance(points, Mapping) else [0]


def check_schedule(what: str, points: Schedule) -> None:
    """Refuse anything but a number or points, and negative numbers; `what` says whose they are.

    Raises:
        ValueError: naming the value. YAML reads 1e6 as text: write 1000000.
    """
    pairs = points.items() if isinstance(points, Mapping) else [(0, points)]
    if not pairs or not all(isinstance(number, Real) and number >= 0 for pair in pairs for number in pair):
        raise ValueError(f"{what} must be a number or {{samples: number}}, none of them negative, not {points!r}")


def highest(points: Schedule) -> float:
    """The largest value that a schedule takes."""
    return max(points.values()) if isinstance(points, Mapping) else points


def check_number(what: str, number: float) -> None:
    """Refuse anything but a number that is not negative; `what` says whose it is.

    Raises:
        ValueError: naming the value.
    """
    if not (isinstance(number, Real) and number >= 0):
        raise ValueError(f"{what} must be a number that is not negative, not {number!r}")


def two(what: str, given: Sequence[Any]) -> tuple[Any, Any]:
    """The two values given; `what` says whose they are.

    Raises:
        ValueError: for anything but a sequence of two.
    """
    if not isinstance(given, Sequence) or len(given) != 2 or isinstance(given, str):
        raise ValueError(f"{what} must be two values, as in [1, 2], not {given!r}")
    return given[0], given[1]


def checked_decay(what: str, decay: float) -> float:
    """What an update leaves of a running average; `what` says whose it is.

    Raises:
        ValueError: for anything but a number that is at least 0 and below 1.
    """
    if not (isinstance(decay, Real) and 0 <= decay < 1):
        raise ValueError(f"{what} must be a number that is at least 0 and below 1, not {decay!r}")
    return decay
