"""What came before a failure is tried again until it succeeds, but not for ever."""

import numpy as np
import pytest

from adapt_envs.simulation.situations import Situations
from sb3_adaptnet.algorithms.retries import BACK, KEPT, TRIES, Retries

WORLDS = 6


def situations(time):
    """Of all worlds: positions tell the world, and speeds the time."""
    numbers = np.arange(WORLDS, dtype=np.float64)
    rows = [np.zeros((WORLDS, 5, 15, 13)), np.zeros((WORLDS, 2)), np.full(WORLDS, time), np.zeros(WORLDS)]
    return Situations(numbers[:, None], numbers[:, None], *rows, np.zeros(WORLDS, np.int64))


@pytest.fixture
def retries():
    found = Retries(WORLDS, np.random.default_rng(0))
    for time in range(100):
        found.watch(situations(time))
    return found


def test_a_retry_begins_before_the_failure_or_where_the_episode_did(retries):
    retries.note(np.array([2, 4]), np.array([80, 10]))
    assert len(retries) == 2
    worlds, again = retries.draw(np.arange(WORLDS), 1.0)
    assert len(set(worlds)) == 2
    found = dict(zip(again.qpos[:, 0], again.speed, strict=True))
    assert found == {2: 100 - BACK, 4: 90}
    assert len(retries) == 0


def test_nothing_is_drawn_where_nothing_waits_or_no_share_is_wanted(retries):
    for share in (1.0, 0.0):
        worlds, again = retries.draw(np.arange(WORLDS), share)
        assert len(worlds) == 0
        assert again is None
        retries.note(np.array([2]), np.array([80]))
    assert len(retries) == 2


def test_what_was_not_watched_is_not_taken_up(retries):
    retries.forget()
    retries.note(np.array([2]), np.array([80]))
    assert len(retries) == 0
    retries.watch(situations(200))
    retries.note(np.array([2]), np.array([80]))
    assert retries.draw(np.array([0]), 1.0)[1].speed.tolist() == [200]


def test_what_fails_again_and_again_is_given_up(retries):
    retries.note(np.array([1]), np.array([80]))
    for _ in range(TRIES):
        assert len(retries) == 1
        worlds, _ = retries.draw(np.array([3]), 1.0)
        assert worlds.tolist() == [3]
        retries.note(worlds, np.array([20]))
    assert len(retries) == 0


def test_another_failure_and_another_episode_count_anew(retries):
    retries.note(np.array([1]), np.array([80]))
    for _ in range(2 * TRIES):
        worlds, _ = retries.draw(np.array([3]), 1.0)
        retries.note(worlds, np.array([BACK + 1]))
    for _ in range(2 * TRIES):
        worlds, _ = retries.draw(np.array([3]), 1.0)
        retries.begin(worlds)
        retries.note(worlds, np.array([5]))
    assert len(retries) == 1


def test_the_latest_wait_also_after_some_were_drawn():
    retries = Retries(WORLDS, np.random.default_rng(0))
    for time in range(KEPT + 20):
        retries.watch(situations(time))
        retries.note(np.array([0]), np.array([1]))
        if time == KEPT - 1:
            drawn = retries.draw(np.arange(WORLDS), 1.0)[1].speed.tolist()
    waiting = [retries.draw(np.array([1]), 1.0)[1].speed[0] for _ in range(KEPT)]
    left = [time for time in range(KEPT + 20) if time not in drawn]
    assert sorted(waiting) == left[-KEPT:]
    assert len(retries) == 0


def test_as_many_are_drawn_as_wanted(retries):
    for _ in range(KEPT + 5):
        retries.note(np.array([0]), np.array([50]))
    assert len(retries) == KEPT
    drawn = [len(retries.draw(np.arange(WORLDS), 0.3)[0]) for _ in range(200)]
    assert 1.5 < np.mean(drawn) < 2.1
    assert len(retries) == KEPT - sum(drawn)
