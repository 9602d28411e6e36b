"""Numbers that may change with the samples seen: one number, or points that are joined by straight lines."""

from collections.abc import Mapping

import numpy as np

Points = float | Mapping[int, float]
"""A number, or samples -> number, such as ``{0: 0.5, 1_000_000: 0.2}``; constant outside them."""


def value_at(points: Points, samples: int) -> float:
    """The number after ``samples`` samples."""
    if not isinstance(points, Mapping):
        return float(points)
    at = sorted(points)
    return float(np.interp(samples, at, [points[sample] for sample in at]))


def numbers_of(points: Points) -> list[float]:
    """Every number that is named."""
    return [float(value) for value in (points.values() if isinstance(points, Mapping) else [points])]
