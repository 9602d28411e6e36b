"""Each world's window of a rollout is what happened from its own start on; episodes' beginnings come up often."""

from dataclasses import replace

import numpy as np
import pytest
from rollout_cases import quiet

WINDOW = 4


@pytest.fixture
def rollout(make_svg):
    svg = make_svg(episodes={"steps": (5, 9), "loose_share": 0}, n_steps=16)
    svg.learn(96)
    svg.collect_rollout(quiet())
    return svg._rollouts.latest(1)[0]


def test_a_window_is_what_happened_from_each_start_on(rollout):
    starts = np.array([0, 3, 12, 1, 7, 5])
    part, data = rollout.window(starts, WINDOW), rollout.transitions
    assert len(part) == WINDOW
    for world, start in enumerate(starts):
        during, states = slice(start, start + WINDOW), slice(start, start + WINDOW + 1)
        for name in ("noise", "frames", "phases", "headings", "turn_rates", "style", "failed"):
            assert np.array_equal(getattr(part, name)[:, world], getattr(rollout, name)[during, world])
        for found, all_of_it in ((part, rollout), (part.transitions, data)):
            for name in ("targets", "speeds") if found is part else ("qpos", "qvel"):
                assert np.array_equal(getattr(found, name)[:, world], getattr(all_of_it, name)[states, world])
        assert np.array_equal(part.transitions.actions[:, world], data.actions[during, world])
        assert np.array_equal(part.transitions.ended[:, world], data.ended[during, world])
    assert np.array_equal(part.strengths, rollout.strengths)


def test_windows_fit_and_begin_where_episodes_do_more_often_than_elsewhere(rollout):
    rng, draws = np.random.default_rng(0), 4000
    starts = np.stack([rollout.drawn_starts(WINDOW, rng) for _ in range(draws)])
    last = len(rollout) - WINDOW
    assert (starts.min(), starts.max()) == (0, last)
    ended = rollout.transitions.ended
    world = int(np.argmax(ended[WINDOW : last - 1].sum(0)))
    (end,) = (WINDOW + np.flatnonzero(ended[WINDOW : last - 1, world]))[:1]
    assert not ended[end - WINDOW + 1 : end, world].any()  # episodes are longer than a window
    found = np.bincount(starts[:, world], minlength=last + 1) / draws
    assert found[end + 1] == pytest.approx((1 + 0.5 * WINDOW) / (last + 1), abs=0.03)
    assert found[end] == pytest.approx(0.5 / (last + 1), abs=0.02)


def test_no_window_moves_to_where_nothing_is_learned(rollout):
    """In a mirror many steps in a row may count as ended."""
    ended = np.zeros_like(rollout.transitions.ended)
    ended[6:11] = True
    masked = replace(rollout, transitions=replace(rollout.transitions, ended=ended))
    rng = np.random.default_rng(0)
    starts = np.stack([masked.drawn_starts(WINDOW, rng) for _ in range(2000)])
    found = np.bincount(starts.ravel(), minlength=13) / starts.size
    assert found[[*range(7), 12]] == pytest.approx(1 / 13, abs=0.01)
    assert found[7:11] == pytest.approx([1 / 13] * 3 + [0.5 / 13], abs=0.01)
    assert found[11] == pytest.approx(1.5 / 13, abs=0.01)
