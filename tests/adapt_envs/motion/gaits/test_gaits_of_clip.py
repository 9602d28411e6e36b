"""Gait cycles that are cut out of a motion of minutes stand as it does."""

import numpy as np
import pytest

from adapt_envs.motion.gaits.draft import from_poses
from adapt_envs.motion.gaits.gaits_of_clip import gaits_of
from adapt_envs.motion.gaits.planted_feet import corners_in_world, standing
from adapt_envs.motion.library import load_clip

IN_THE_AIR = 0.015


@pytest.mark.parametrize(
    ("name", "speeds", "flight"), [("walk", [0.4, 0.6, 1.1], (0.0, 0.0)), ("run", [1.9, 2.3, 2.75], (0.08, 0.2))]
)
def test_feet_of_gaits_stand_on_the_ground_and_do_not_slide(name, speeds, flight):
    for gait in gaits_of(load_clip(name), speeds):
        draft = from_poses(gait.qpos)
        corners = corners_in_world(draft.foot_pos, draft.foot_quat)
        heights, sliding = stances_of(corners)
        assert np.abs(heights).max() < 0.002
        assert np.median(sliding) < 0.01
        assert np.percentile(sliding, 90) < 0.25  # a running foot lands and leaves while it is counted
        in_the_air = corners[:-1, ..., 2].min(axis=(1, 2)) > IN_THE_AIR
        assert flight[0] <= in_the_air.mean() <= flight[1]


def stances_of(corners):
    """Heights [m] and speeds [m/s] of the lowest corner of each foot, in frames in which it stands."""
    heights, sliding = [], []
    for side in range(2):
        foot = corners[:, side]
        rows, lowest = np.flatnonzero(standing(foot)[:-1]), foot[..., 2].argmin(axis=1)
        heights.append(foot[rows, lowest[rows], 2])
        step = foot[rows + 1, lowest[rows], :2] - foot[rows, lowest[rows], :2]
        sliding.append(np.linalg.norm(step, axis=1) * 30)
    return np.concatenate(heights), np.concatenate(sliding)


def test_no_cycle_is_cut_out_twice():
    cut = gaits_of(load_clip("walk"), [1.0, 1.1, 1.3])  # the first two are met by the same frames
    assert len({gait.origin for gait in cut}) == len(cut) == 2
    assert gaits_of(load_clip("walk"), (1.0, 1.1, 1.3)) == cut  # nor for another body: they are the same clips
