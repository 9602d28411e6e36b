"""Start states that failed come again, until they succeed."""

import numpy as np

from sb3_adaptnet.algorithms.retries import KEPT, Retries


def test_soon_failed_starts_wait_and_leave_when_drawn():
    retries = Retries(np.random.default_rng(0))
    retries.note(np.array([7, 8, 9]), np.array([60, 61, 1]))
    assert len(retries) == 2
    assert len(retries.draw(4, 0.0)) == 0
    assert set(retries.draw(4, 1.0)) == {7, 9}
    assert len(retries) == 0


def test_a_share_of_the_episodes_begins_in_them():
    retries = Retries(np.random.default_rng(0))
    retries.note(np.arange(KEPT + 5), np.ones(KEPT + 5))
    assert len(retries) == KEPT
    drawn = retries.draw(1000, 0.3)
    assert 250 < len(drawn) < 350 and len(set(drawn)) == len(drawn) and drawn.min() >= 5
    assert len(retries) == KEPT - len(drawn)
