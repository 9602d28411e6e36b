"""Time warping against all paths of small problems."""

import numpy as np
import pytest

from sb3_adaptnet.evaluation.warping import match


def all_matches(frames, length, leap=1, rest=2):
    """Every match that single steps, leaps and rests in stretches of so many frames allow, as lists of frames."""
    pieces = ([1], [2] + [1] * (leap - 1), [1, 0] + [1] * (rest - 2))

    def grow(matched):
        if len(matched) == frames:
            yield matched
        for piece in pieces:
            steps = list(matched[-1] + np.cumsum(piece))
            if len(matched) + len(piece) <= frames and steps[-1] < length:
                yield from grow([*matched, *steps])

    for first in range(length):
        yield from grow([first])
        if frames >= rest and first + rest - 2 < length:
            yield from grow([first, *range(first, first + rest - 1)])


@pytest.mark.parametrize("frames, length", [(1, 1), (2, 1), (3, 2), (4, 6), (6, 5), (7, 4)])
def test_the_cheapest_of_all_paths_is_found(frames, length):
    for seed in range(8):
        cost = np.random.default_rng(seed).uniform(size=(frames, length))
        best = min(cost[np.arange(frames), path].sum() for path in all_matches(frames, length))
        assert cost[np.arange(frames), match(cost)].sum() == pytest.approx(best)


@pytest.mark.parametrize("leap, rest", [(2, 3), (1, 4), (3, 2), (4, 3)])
def test_the_cheapest_of_all_paths_within_bounds_of_the_tempo_is_found(leap, rest):
    for seed in range(8):
        cost = np.random.default_rng(seed).uniform(size=(8, 9))
        best = min(cost[np.arange(8), path].sum() for path in all_matches(8, 9, leap, rest))
        found = match(cost, slowest=1 - 1 / rest, fastest=1 + 1 / leap)
        assert cost[np.arange(8), found].sum() == pytest.approx(best)


def test_no_stretch_of_the_reference_runs_beyond_the_bounds():
    cost = np.random.default_rng(1).uniform(size=(80, 120))
    steps = np.diff(match(cost, 0.85, 1.15))
    assert {0, 2} <= set(steps)
    for kind in (0, 2):
        assert np.diff(np.flatnonzero(steps == kind)).min() >= 7
    assert 0.85 <= steps.mean() <= 1.15


def test_the_reference_runs_at_half_to_double_speed():
    cost = np.random.default_rng(1).uniform(size=(60, 90))
    matched = match(cost)
    steps = np.diff(matched)
    assert set(steps) <= {0, 1, 2}
    assert not ((steps[:-1] == 0) & (steps[1:] == 0)).any()


@pytest.mark.parametrize("speeds", [[1], [2], [1, 2], [1, 0], [2, 1, 1, 0]])
def test_a_warped_stretch_of_the_reference_is_found_again(speeds):
    reference = np.random.default_rng(2).normal(size=120)
    frames = 17 + np.concatenate([[0], np.cumsum(np.resize(speeds, 39))])
    assert match(np.abs(reference[frames][:, None] - reference)).tolist() == frames.tolist()


def test_a_reference_of_less_than_half_is_refused():
    with pytest.raises(ValueError, match="5 frames cannot be matched to 2 at a tempo of 0.5"):
        match(np.zeros((5, 2)))
    with pytest.raises(ValueError, match="14 frames cannot be matched to 11"):
        match(np.zeros((14, 11)), slowest=0.85)
