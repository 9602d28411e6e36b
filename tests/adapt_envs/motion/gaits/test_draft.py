"""Drafts: rotations of ball joints as angles within their limits."""

import numpy as np
import pytest

from adapt_envs.features import rotations
from adapt_envs.model.build import plain_model
from adapt_envs.motion.gaits.draft import angles_within


@pytest.mark.parametrize("joint", ["left_shoulder", "right_shoulder", "left_hip", "right_hip"])
def test_angles_within_finds_angles_inside_the_limits(joint):
    """Also where the y angle is beyond a quarter turn, which the plain extraction cannot give."""
    model = plain_model()
    ranges = np.array([model.jnt_range[model.joint(f"{joint}_{axis}").id] for axis in "xyz"])
    rng = np.random.default_rng(0)
    targets = rng.uniform(ranges[:, 0], ranges[:, 1], (200, 3))
    quats = rotations.from_intrinsic_xyz(targets)
    for target, quat in zip(targets, quats, strict=True):
        found = angles_within(quat[None], joint)
        again = rotations.from_intrinsic_xyz(found)
        assert abs(np.sum(again * quat)) == pytest.approx(1, abs=1e-9)
        assert (found >= ranges[:, 0] - 1e-9).all() and (found <= ranges[:, 1] + 1e-9).all(), target
