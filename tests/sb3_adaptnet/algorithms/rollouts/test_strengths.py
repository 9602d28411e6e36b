"""Some rollouts are made at part of an adaptation's strength, and learned from at that strength."""

import numpy as np
import pytest
import torch
from rollout_cases import quiet

from sb3_adaptnet import SVG, AdaptVecEnv, PretrainPolicy
from sb3_adaptnet.algorithms.rollouts.strengths import STEPS, acting_at, strength_at


def test_strengths_stay_for_a_while_and_then_change():
    worlds = 10
    at = [strength_at(samples, worlds, share=1.0) for samples in range(0, 3 * STEPS * worlds, worlds)]
    for block in np.split(np.array(at), 3):
        assert len(set(block)) == 1
    assert len(set(at)) == 3


def test_a_share_of_the_time_is_spread_evenly_over_all_strengths():
    found = np.array([strength_at(block * STEPS * 4, 4, share=0.5) for block in range(2000)])
    parts = found[found < 1]
    assert 0.46 < len(parts) / len(found) < 0.54
    assert np.abs(np.histogram(parts, 4, (0, 1))[0] / len(parts) - 0.25).max() < 0.05
    assert all(strength_at(block * STEPS * 4, 4, share=0.0) == 1 for block in range(100))


@pytest.fixture
def svg(make_svg):
    choices = {"exploration": {"std": 0.0}, "guiding": {"least_style": 1.0}}
    return make_svg(episodes={"partial_share": 1.0}, **choices).learn(96)


def test_a_rollout_acts_in_part_and_says_so(svg):
    rollout = svg._rollouts.latest(1)[0]
    assert 0 < rollout.strength < 1
    assert svg.policy.alpha == 1
    before = svg._last_obs
    with svg.weight_average.learning(), acting_at(svg.policy, svg._worlds.strength):
        there, _ = svg._act(before)
    with svg.weight_average.learning():
        whole, _ = svg._act(before)
    assert not np.allclose(there, whole, atol=1e-6)
    svg.collect_rollout(quiet())
    assert svg._rollouts.latest(1)[0].strength == svg._worlds.strength
    assert np.allclose(svg._rollouts.latest(1)[0].transitions.actions[0], there, atol=1e-6)


def test_what_is_learned_from_it_acts_as_it_did_and_style_counts_by_the_square(svg, monkeypatch):
    rollout, alphas = svg._rollouts.latest(1)[0], []
    mean_action = svg._mean_action
    monkeypatch.setattr(svg, "_mean_action", lambda obs: alphas.append(svg.policy.alpha) or mean_action(obs))
    svg.train()
    assert set(alphas) == {rollout.strength}  # of all rollouts so far
    assert svg.policy.alpha == 1
    assert rollout.style == pytest.approx(rollout.strength**2, rel=1e-5)
    guided = rollout.guided(0, np.ones(6, bool), np.zeros(6, bool), torch.device("cpu"))
    assert guided.strengths.tolist() == pytest.approx([rollout.strength] * 6)


def test_it_is_scaled_back_whatever_happens(svg):
    svg.policy.alpha = 0.8
    with pytest.raises(KeyError), acting_at(svg.policy, 0.5):
        assert svg.policy.alpha == 0.4
        raise KeyError
    assert svg.policy.alpha == 0.8
    with acting_at(svg.policy, 1.0):
        assert svg.policy.alpha == 0.8


def test_a_policy_without_alpha_is_refused(tiny_world):
    env = AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=2, num_threads=1)
    share = {0: 0.0, 100: 0.5}
    with pytest.raises(ValueError, match="a PretrainPolicy has no alpha, which partial_share .*100: 0.5.* must be 0"):
        SVG(PretrainPolicy, env, tiny_world, episodes={"partial_share": share}, device="cpu")
