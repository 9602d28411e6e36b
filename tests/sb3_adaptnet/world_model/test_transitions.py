"""Windows stay within episodes; worlds are held out whole."""

import numpy as np
import pytest
from world_cases import recorded

from sb3_adaptnet.world_model.fitting.fit import sample_starts
from sb3_adaptnet.world_model.transitions import Transitions


@pytest.fixture(scope="module")
def data():
    return recorded(steps=24, worlds=32)


def test_windows_stay_within_episodes():
    ended = np.zeros((6, 2), bool)
    ended[2, 0] = True
    numbers = np.arange(14, dtype=np.float32).reshape(7, 2, 1)
    data = Transitions(numbers, numbers, numbers[:6], ended)
    assert {tuple(start) for start in data.starts(3)} == {(3, 0), (0, 1), (1, 1), (2, 1), (3, 1)}
    assert len(data.starts(1)) == 11
    with pytest.raises(ValueError, match="no episode of the data has 7 transitions"):
        sample_starts(data, 7, 1, np.random.default_rng(0))


def test_worlds_are_held_out_whole(data):
    fitted, judged = data.split(4)
    assert (fitted.num_worlds, judged.num_worlds) == (24, 8)
    assert np.array_equal(judged.actions, data.actions[:, ::4])
    with pytest.raises(ValueError, match="every 33th of 32 worlds"):
        data.split(33)
