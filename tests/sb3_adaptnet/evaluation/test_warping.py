"""Time warping against all paths of small problems."""

import numpy as np
import pytest

from sb3_adaptnet.evaluation.warping import match


def all_matches(frames, length):
    """Every match that steps (1, 1), (1, 2) and (2, 1) allow, as lists of reference frames."""

    def grow(matched, r):
        if len(matched) == frames:
            yield matched
        for count, advance in ((1, 1), (1, 2), (2, 1)):
            if len(matched) + count <= frames and r + advance < length:
                yield from grow(matched + [r + advance] * count, r + advance)

    for first in range(length):
        for count in (1, 2):
            if count <= frames:
                yield from grow([first] * count, first)


@pytest.mark.parametrize("frames, length", [(1, 1), (2, 1), (3, 2), (4, 6), (6, 5), (7, 4)])
def test_the_cheapest_of_all_paths_is_found(frames, length):
    for seed in range(8):
        cost = np.random.default_rng(seed).uniform(size=(frames, length))
        best = min(cost[np.arange(frames), path].sum() for path in all_matches(frames, length))
        assert cost[np.arange(frames), match(cost)].sum() == pytest.approx(best)


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
    with pytest.raises(ValueError, match="5 frames cannot be matched to 2"):
        match(np.zeros((5, 2)))
