"""Start states that failed come again, until they succeed."""

import numpy as np

from sb3_adaptnet.algorithms.retries import KEPT, Retries


def test_soon_failed_starts_wait_and_leave_when_drawn():
    retries = Retries(np.random.default_rng(0))
    retries.note(np.array([7, 8, 9]), np.array([60, 61, 1]))
    assert len(retries) == 2
    drawn = retries.draw(np.array([1, 2, 3, 4]), 1.0)
    assert set(drawn) == {7, 9, 3, 4}
    assert len(retries) == 0


def test_a_share_of_the_starts_is_replaced():
    retries = Retries(np.random.default_rng(0))
    retries.note(np.full(KEPT + 5, 50), np.ones(KEPT + 5))
    assert len(retries) == KEPT
    drawn = retries.draw(np.zeros(1000, np.int64), 0.3)
    assert 250 < (drawn == 50).sum() < 350
    assert len(retries) == KEPT - (drawn == 50).sum()
