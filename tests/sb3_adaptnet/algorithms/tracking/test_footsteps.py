"""Two footsteps make a stride, however many strides a motion holds."""

import numpy as np
import pytest

from sb3_adaptnet.algorithms.tracking.footsteps import footsteps_per_second


def swings(phases, stride):
    return np.maximum(np.sin(2 * np.pi * np.arange(phases) / stride), 0.0)


@pytest.mark.parametrize(("phases", "stride"), [(66, 66), (60, 30), (84, 28)])
def test_a_cycle_is_one_stride_or_several(phases, stride):
    assert footsteps_per_second(swings(phases, stride), cyclic=True) == pytest.approx(60 / stride)


def test_strides_are_found_in_motions_that_do_not_repeat():
    assert footsteps_per_second(swings(100, 32), cyclic=False) == pytest.approx(60 / 32)


def test_a_foot_that_stays_takes_no_steps():
    assert footsteps_per_second(np.zeros(50), cyclic=True) == np.inf
    assert footsteps_per_second(np.arange(5.0), cyclic=False) == np.inf
