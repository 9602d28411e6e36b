"""Footsteps are landings, however many of them make a stride."""

import numpy as np
import pytest

from sb3_adaptnet.algorithms.tracking.footsteps import LANDED, LIFTED, footsteps_per_second


def swings(phases, stride, height=0.1):
    """Two feet (2, phases) that swing by turns, once per `stride` phases."""
    angle = 2 * np.pi * np.arange(phases) / stride
    return height * np.maximum(np.sin([angle, angle + np.pi]), 0.0)


@pytest.mark.parametrize(("phases", "stride"), [(66, 66), (60, 30), (84, 28)])
def test_each_foot_lands_once_a_stride(phases, stride):
    assert footsteps_per_second(swings(phases, stride), cyclic=True) == pytest.approx(60 / stride)


def test_a_motion_that_does_not_repeat_lands_at_its_end_if_it_shows_that():
    heights = swings(105, 40)[:1]  # in the air for 20 phases at 0, 40 and 80
    assert footsteps_per_second(heights, cyclic=False) == pytest.approx(3 * 30 / 105)
    assert footsteps_per_second(heights[:, :90], cyclic=False) == pytest.approx(2 * 30 / 90)


def test_a_hop_is_a_landing_too():
    heights = swings(48, 48)
    heights[0] += swings(48, 24, 0.05)[1] * (np.arange(48) >= 24)
    assert footsteps_per_second(heights, cyclic=True) == pytest.approx(3 * 30 / 48)


def test_a_landing_is_found_wherever_a_cycle_begins():
    heights = swings(40, 40)
    found = [footsteps_per_second(np.roll(heights, shift, axis=1), cyclic=True) for shift in range(40)]
    assert found == pytest.approx([1.5] * 40)


def test_trembling_is_no_landing():
    trembling = 0.9 * (LIFTED - LANDED) * np.random.default_rng(0).random((2, 60))
    assert footsteps_per_second(trembling, cyclic=True) == np.inf
    assert footsteps_per_second(swings(60, 60) + trembling, cyclic=True) == pytest.approx(1.0)


def test_a_foot_that_stays_takes_no_steps():
    assert footsteps_per_second(np.zeros((2, 50)), cyclic=True) == np.inf
    assert footsteps_per_second(np.linspace(0, 1, 5)[None], cyclic=False) == np.inf
