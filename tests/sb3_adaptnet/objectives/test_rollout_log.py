"""What is kept of a rollout."""

import numpy as np
import pytest

from sb3_adaptnet.objectives.rollout_log import CONTROL_HZ, Rollout


def info(limit, observation=None):
    return {"TimeLimit.truncated": limit, "terminal_observation": observation, "episode": {"l": 5}}


@pytest.mark.parametrize("box", [True, False], ids=["box", "dict"])
def test_observations_to_bootstrap_are_the_cut_ones_and_then_the_last(box):
    rollout = Rollout(2, 3)
    wrap = (lambda rows: rows) if box else (lambda rows: {"observation": rows, "heightmap": -rows})
    last = wrap(np.arange(6.0).reshape(3, 2))
    assert rollout.observations_to_bootstrap(last) is last
    dones = np.array([True, False, True])
    infos = [info(True, wrap(np.array([7.0, 8.0]))), {}, info(False)]
    rollout.add({"goal": np.ones(3)}, dones, infos, None)
    found = rollout.observations_to_bootstrap(last)
    flat = found if box else found["observation"]
    np.testing.assert_array_equal(flat, [[7, 8], [0, 1], [2, 3], [4, 5]])
    assert box or np.array_equal(found["heightmap"], -flat)


def test_falls_per_minute_count_every_end_but_the_time_limit():
    rollout = Rollout(CONTROL_HZ, 2)  # a second of two worlds
    for step in range(CONTROL_HZ):
        dones = np.array([step == 3, step == 7])
        rollout.add({"goal": np.ones(2)}, dones, [info(False), info(True, np.zeros(1))], None)
    assert rollout.falls_per_minute() == pytest.approx(30.0)
    assert rollout.terminated.sum() == 1 and [limit[:2] for limit in rollout.time_limits] == [(7, 1)]
