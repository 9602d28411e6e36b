"""Batches of observations: one array, or a dict of arrays where there is a heightmap, too."""

import numpy as np
from numpy.typing import NDArray

Observations = NDArray[np.float32] | dict[str, NDArray[np.float32]]
"""(n, 784), or {"observation": (n, 784), "heightmap": (n, 1, 35, 35)}."""
Rows = NDArray[np.integer] | NDArray[np.bool_] | int | slice


def rows_of(observations: Observations, rows: Rows) -> Observations:
    """A copy of some rows."""
    if isinstance(observations, dict):
        return {key: values[rows].copy() for key, values in observations.items()}
    return observations[rows].copy()


def put_rows(observations: Observations, rows: Rows, values: Observations) -> None:
    """Overwrite some rows in place."""
    if isinstance(observations, dict) and isinstance(values, dict):
        for key, part in values.items():
            observations[key][rows] = part
    elif not isinstance(observations, dict) and not isinstance(values, dict):
        observations[rows] = values
    else:
        raise TypeError("observations with and without a heightmap do not go together")


def empty_like(observations: Observations, n: int) -> Observations:
    """`n` rows of zeros in the layout of `observations`."""
    if isinstance(observations, dict):
        return {key: np.zeros((n, *values.shape[1:]), np.float32) for key, values in observations.items()}
    return np.zeros((n, *observations.shape[1:]), np.float32)
