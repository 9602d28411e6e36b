"""Some rollouts are made at part of an adaptation's strength, and learned from at that strength."""

import numpy as np
import pytest
import torch
from rollout_cases import quiet

from sb3_adaptnet import SVG, AdaptVecEnv, PretrainPolicy
from sb3_adaptnet.algorithms.rollouts.strengths import STEPS, acting_at, strengths_at
from sb3_adaptnet.modules.adaptation.at_alpha import at_alpha
from sb3_adaptnet.modules.adaptation.in_part import InPart


def test_strengths_stay_for_a_while_and_then_change():
    worlds = 10
    at = [strengths_at(samples, worlds, share=1.0) for samples in range(0, 3 * STEPS * worlds, worlds)]
    for block in np.split(np.array(at), 3):
        assert (block == block[0]).all()
    assert len(np.unique(at)) == 3 * worlds


def test_a_share_of_the_time_is_spread_evenly_over_all_strengths():
    found = np.array([strengths_at(block * STEPS * 4, 4, share=0.5) for block in range(1000)])
    for world in found.T:
        parts = world[world < 1]
        assert 0.45 < len(parts) / len(world) < 0.55
        assert np.abs(np.histogram(parts, 4, (0, 1))[0] / len(parts) - 0.25).max() < 0.06
    assert all((strengths_at(block * STEPS * 4, 4, share=0.0) == 1).all() for block in range(100))


@pytest.fixture
def svg(make_svg):
    choices = {"exploration": {"std": 0.0}, "guiding": {"least_style": 1.0}}
    return make_svg(episodes={"partial_share": 0.7}, **choices).learn(96)


def test_a_rollout_acts_in_part_and_says_so(svg):
    svg.collect_rollout(quiet())
    rollout = svg._rollouts.latest(1)[0]
    assert np.array_equal(rollout.strengths, svg._worlds.strengths)
    assert (rollout.strengths < 1).any() and (rollout.strengths == 1).any()
    before = svg._last_obs
    with svg.weight_average.learning(), torch.no_grad():
        there = svg._mean_actions(before, svg._worlds.strengths, svg._worlds.companions).clip(-1, 1)
        for world, strength in enumerate(rollout.strengths):
            with at_alpha(svg.policy, float(strength)):
                alone = svg._mean_action(torch.as_tensor(before)).clamp(-1, 1)[world]
            assert np.allclose(there[world], alone, atol=1e-6)
    svg.collect_rollout(quiet())
    assert np.allclose(svg._rollouts.latest(1)[0].transitions.actions[0], there, atol=1e-6)


def test_what_is_learned_from_it_acts_as_it_did_and_style_counts_by_the_square(svg, monkeypatch):
    rollout, acted = svg._rollouts.latest(1)[0], []
    mean_action = svg._mean_action
    monkeypatch.setattr(
        svg, "_mean_action", lambda obs, companions: acted.append(svg.policy.actor.in_part) or mean_action(obs)
    )
    svg.train()
    of_all = InPart.of(torch.as_tensor(rollout.strengths))  # the same in all rollouts so far
    assert acted and all(part.rows.equal(of_all.rows) and part.strengths.equal(of_all.strengths) for part in acted)
    assert svg.policy.actor.in_part is None
    assert np.allclose(rollout.style, rollout.strengths**2)
    guided = rollout.guided(0, np.ones(6, bool), np.zeros(6, bool), torch.device("cpu"))
    assert np.array_equal(guided.strengths, rollout.strengths)


def test_all_of_it_acts_again_whatever_happens(svg):
    with pytest.raises(KeyError), acting_at(svg.policy, np.array([1.0, 0.5])):
        assert svg.policy.actor.in_part.rows.tolist() == [1]
        raise KeyError
    assert svg.policy.actor.in_part is None
    with acting_at(svg.policy, np.ones(2)):
        assert svg.policy.actor.in_part is None


def test_a_policy_without_alpha_is_refused(tiny_world):
    env = AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=2, num_threads=1)
    share = {0: 0.0, 100: 0.5}
    with pytest.raises(ValueError, match="a PretrainPolicy has no alpha, which partial_share .*100: 0.5.* must be 0"):
        SVG(PretrainPolicy, env, tiny_world, episodes={"partial_share": share}, device="cpu")
