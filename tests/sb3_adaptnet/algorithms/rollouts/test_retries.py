"""What came before a failure is tried again until it succeeds for good, but not for ever."""

import numpy as np
import pytest

from adapt_envs.simulation.situations import Situations
from sb3_adaptnet.algorithms.rollouts.retries import BACK, KEPT, LENGTHS, SUCCESSES, TRIES, Retries

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
    retries.failed(np.array([2, 4]), np.array([80, 10]))
    assert len(retries) == 2
    worlds, again = retries.draw(np.arange(WORLDS), 1.0)
    assert len(set(worlds)) == 2
    found = dict(zip(again.qpos[:, 0], again.speed, strict=True))
    assert 100 - BACK[1] <= found[2] <= 100 - BACK[0]
    assert found[4] == 90
    assert len(retries) == 0


@pytest.mark.parametrize(("steps", "earliest"), [(45, 45), (5, BACK[0]), (99, BACK[1])])
def test_a_retry_does_not_begin_before_the_target_but_that_was_new(retries, steps, earliest):
    for time in range(100, 100 + steps):
        now = situations(time)
        now.target[2] = 1.0
        retries.watch(now)
    for _ in range(200):
        retries.failed(np.array([2]), np.array([300]))
    backs = 100 + steps - np.array([retries.draw(np.array([0]), 1.0)[1].speed[0] for _ in range(200)])
    assert (backs.min(), backs.max()) == (BACK[0], earliest)


def test_a_retry_is_short(retries):
    retries.failed(np.array([2]), np.array([80]))
    retries.draw(np.array([3]), 1.0)
    steps = np.array([retries.lengths(np.arange(2, 5)) for _ in range(500)])
    assert (steps.min(axis=0).tolist(), steps.max(axis=0).tolist()) == ([0, LENGTHS[0], 0], [0, LENGTHS[1], 0])
    retries.succeeded(np.array([3]))
    assert retries.lengths(np.array([3])) == [0]


def test_nothing_is_drawn_where_nothing_waits_or_no_share_is_wanted(retries):
    for share in (1.0, 0.0):
        worlds, again = retries.draw(np.arange(WORLDS), share)
        assert len(worlds) == 0
        assert again is None
        retries.failed(np.array([2]), np.array([80]))
    assert len(retries) == 2


def test_what_was_not_watched_is_not_taken_up(retries):
    retries.forget()
    retries.failed(np.array([2]), np.array([80]))
    assert len(retries) == 0
    retries.watch(situations(200))
    retries.failed(np.array([2]), np.array([80]))
    assert retries.draw(np.array([0]), 1.0)[1].speed.tolist() == [200]


def test_what_succeeds_often_in_a_row_is_over(retries):
    def one_try(fails):
        worlds, _ = retries.draw(np.array([3]), 1.0)
        if fails:
            retries.failed(worlds, np.array([80]))
        else:
            retries.succeeded(worlds)

    retries.failed(np.array([1]), np.array([80]))
    for _ in range(SUCCESSES - 1):
        one_try(fails=False)
    one_try(fails=True)  # so what went well before counts no longer
    for _ in range(SUCCESSES):
        assert len(retries) == 1
        one_try(fails=False)
    assert len(retries) == 0


def test_an_episode_that_is_no_retry_adds_nothing_by_its_success(retries):
    retries.succeeded(np.arange(WORLDS))
    assert len(retries) == 0


def test_what_fails_again_and_again_is_given_up(retries):
    retries.failed(np.array([1]), np.array([80]))
    for _ in range(TRIES):
        assert len(retries) == 1
        worlds, _ = retries.draw(np.array([3]), 1.0)
        assert worlds.tolist() == [3]
        retries.failed(worlds, np.array([20]))
    assert len(retries) == 0


def test_a_retry_that_failed_waits_as_it_was(retries):
    retries.failed(np.array([1]), np.array([10]))
    for time in range(100, 150):
        worlds, again = retries.draw(np.array([3]), 1.0)
        assert (again.qpos.tolist(), again.speed.tolist()) == ([[1]], [90])
        retries.watch(situations(time))
        retries.failed(worlds, np.array([70]))
        if len(retries) == 0:
            break
    assert time == 99 + TRIES


def test_the_latest_wait_also_after_some_were_drawn():
    retries = Retries(WORLDS, np.random.default_rng(0))
    for time in range(KEPT + 20):
        retries.watch(situations(time))
        retries.failed(np.array([0]), np.array([1]))
        if time == KEPT - 1:
            drawn = retries.draw(np.arange(1, WORLDS), 1.0)[1].speed.tolist()
    waiting = [retries.draw(np.array([1]), 1.0)[1].speed[0] for _ in range(KEPT)]
    left = [time for time in range(KEPT + 20) if time not in drawn]
    assert sorted(waiting) == left[-KEPT:]
    assert len(retries) == 0


def test_as_many_are_drawn_as_wanted(retries):
    for _ in range(KEPT + 5):
        retries.failed(np.array([0]), np.array([50]))
    assert len(retries) == KEPT
    drawn = [len(retries.draw(np.arange(1, WORLDS + 1) % WORLDS, 0.3)[0]) for _ in range(200)]
    assert 1.5 < np.mean(drawn) < 2.1
    assert len(retries) == KEPT - sum(drawn)
