"""The soles of the feet: where they are, and when they touch the ground."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from adapt_envs.model.humanoid import FEET

TOUCHING = 0.015
"""A corner of a sole lower than this touches the ground [m]."""


def sole_corners(model: mujoco.MjModel) -> NDArray[np.float64]:
    """The lower corners of the right and the left sole (2, 4, 3) [m], in the feet's link frames."""
    signs = np.array([(1, 1, -1), (1, -1, -1), (-1, -1, -1), (-1, 1, -1)])
    return np.stack([model.geom(foot).pos + signs * model.geom(foot).size for foot in FEET])
