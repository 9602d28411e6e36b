"""Batches of observations with and without a heightmap: rows taken, copied and overwritten."""

import numpy as np
import pytest

from adapt_envs.features import copied, put_rows, rows_of


def plain(n):
    return np.arange(3.0 * n, dtype=np.float32).reshape(n, 3)


def mapped(n):
    return {"observation": plain(n), "heightmap": plain(n).reshape(n, 1, 3, 1) + 100}


def parts(observations):
    return observations if isinstance(observations, dict) else {"observation": observations}


@pytest.mark.parametrize("made", [plain, mapped])
@pytest.mark.parametrize("rows", [np.array([2, 0]), np.array([True, False, True]), 1, slice(None)])
def test_rows_are_copies_of_the_rows(made, rows):
    whole = made(3)
    taken = rows_of(whole, rows)
    for key, values in parts(taken).items():
        assert np.array_equal(values, parts(made(3))[key][rows])
        values[...] = -1
    for key, values in parts(whole).items():
        assert np.array_equal(values, parts(made(3))[key])


@pytest.mark.parametrize("made", [plain, mapped])
def test_rows_put_back_are_the_rows_taken(made):
    whole, rows = made(5), np.array([4, 1])
    put_rows(whole, rows, rows_of(made(5), np.array([0, 2])))
    expected = [0, 2, 2, 3, 0]  # numbers of the rows that stand there now
    for key, values in parts(whole).items():
        assert np.array_equal(values, parts(made(5))[key][expected])
    for key, values in parts(copied(whole)).items():
        assert np.array_equal(values, parts(whole)[key]) and not np.shares_memory(values, parts(whole)[key])


def test_observations_of_two_kinds_do_not_go_together():
    with pytest.raises(TypeError, match="with and without a heightmap"):
        put_rows(plain(2), 0, mapped(1))
