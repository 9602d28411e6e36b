"""Hinge loss, gradient penalty and reward (eqs. 10 and 11) against autograd and hand-made numbers."""

from copy import deepcopy

import numpy as np
import pytest
import torch

from sb3_adaptnet.modules.discriminator import Discriminator, hinge_loss, imitation_reward, unroll_gru
from sb3_adaptnet.objectives.imitation import ImitationObjective, finite_rows

NETWORK = {"links": 2, "numbers": 3, "heads": 3, "gru": 8, "hidden": (6,)}


def windows(count, seed=0, shift=0.0):
    return (np.random.default_rng(seed).standard_normal((count, 5, 2, 3)) + shift).astype(np.float32)


def test_unrolled_gru_equals_torch():
    torch.manual_seed(0)
    gru, inputs = torch.nn.GRU(4, 7, batch_first=True), torch.randn(6, 5, 4)
    torch.testing.assert_close(unroll_gru(gru, inputs), gru(inputs)[1][0])


def test_hinge_loss_by_hand():
    simulated, reference = torch.tensor([[-2.0, 0.5]]), torch.tensor([[3.0, -1.0]])
    # simulated: 0 and 1.5; reference: 0 and 2; each averaged over the heads
    assert hinge_loss(simulated, reference).item() == pytest.approx(0.75 + 1.0)


def test_reward_clips_each_head_before_averaging():
    scores = torch.tensor([[5.0, -0.5], [-3.0, -3.0], [0.2, 0.4]])
    torch.testing.assert_close(imitation_reward(scores), torch.tensor([0.25, -1.0, 0.3]))


def test_gradient_norms_are_those_of_the_heads_sum_between_the_two():
    torch.manual_seed(0)
    network, simulated, reference = Discriminator(**NETWORK), torch.randn(4, 5, 6), torch.randn(4, 5, 6)
    torch.manual_seed(1)
    norms = network.gradient_norms(simulated, reference)
    torch.manual_seed(1)
    mix = torch.rand(4, 1, 1)
    points = (mix * simulated + (1.0 - mix) * reference).requires_grad_()
    (gradient,) = torch.autograd.grad(network.scores(points).sum(), points)
    torch.testing.assert_close(norms, gradient.flatten(1).square().sum(1).sqrt())


def test_penalty_gradient_against_finite_differences():
    """d/dw of the mean squared (norm - 1) by double backward equals central differences, in double precision."""
    torch.manual_seed(0)
    network = Discriminator(**{**NETWORK, "heads": 1}).double()
    frames = torch.randn(3, 5, 6, dtype=torch.float64)

    def penalty():
        torch.manual_seed(1)
        points = frames.clone().requires_grad_()
        scores = network._head_scores(unroll_gru(network.encoder.gru, points).double())
        (gradient,) = torch.autograd.grad(scores.sum(), points, create_graph=True)
        return (gradient.flatten(1).norm(dim=1) - 1.0).square().mean()

    weight = network.encoder.gru.weight_hh_l0
    (analytic,) = torch.autograd.grad(penalty(), weight)
    for row, column in ((0, 0), (9, 3), (20, 7)):
        with torch.no_grad():
            weight[row, column] += 1e-4
        up = penalty().item()
        with torch.no_grad():
            weight[row, column] -= 2e-4
        down = penalty().item()
        with torch.no_grad():
            weight[row, column] += 1e-4
        # unroll_gru returns float32, so differences carry its rounding
        assert analytic[row, column].item() == pytest.approx((up - down) / 2e-4, rel=0.05, abs=2e-4)


def test_flat_network_gives_zero_gradient_not_nan():
    network = Discriminator(**NETWORK)
    torch.nn.init.zeros_(network.heads.weight)
    norms = network.gradient_norms(torch.randn(4, 5, 6), torch.randn(4, 5, 6))
    (norms - 1.0).square().mean().backward()
    assert torch.equal(norms.detach(), torch.zeros(4))
    assert all(p.grad is None or torch.isfinite(p.grad).all() for p in network.parameters())


@pytest.mark.parametrize("precision", ["fp32", "bf16"])
def test_learns_to_tell_apart_and_rewards_the_reference(precision):
    torch.manual_seed(0)
    objective = ImitationObjective(learning_rate=1e-2, batch_size=64, precision=precision, network=NETWORK)
    rng = np.random.default_rng(0)
    for turn in range(12):
        statistics = objective.update(windows(256, turn, 1.0), windows(256, 100 + turn, -1.0), rng)
    assert statistics["score_difference"] > 1.0
    between = statistics["score_reference"] - statistics["score_simulated"]
    assert statistics["score_difference"] == pytest.approx(between, abs=1e-5)
    reference, simulated = objective.rewards(windows(64, 7, -1.0)), objective.rewards(windows(64, 8, 1.0))
    assert reference.mean() > simulated.mean() + 0.5
    assert np.abs(reference).max() <= 1.0


def test_windows_that_are_not_finite_do_no_harm():
    torch.manual_seed(0)
    objective = ImitationObjective(batch_size=8, network=NETWORK)
    broken = windows(16)
    broken[3, 2, 1, 0], broken[5] = np.nan, np.inf
    assert finite_rows(broken).sum() == 14
    objective.update(broken, windows(16, 1), np.random.default_rng(0))
    rewards = objective.rewards(broken)
    assert np.isfinite(rewards).all() and rewards[3] == rewards[5] == -1.0
    assert all(torch.isfinite(p).all() for p in objective.discriminator.parameters())


def test_state_restores_exactly():
    torch.manual_seed(0)
    first = ImitationObjective(batch_size=16, network=NETWORK)
    first.update(windows(64), windows(64, 1), np.random.default_rng(0))
    second = ImitationObjective(batch_size=16, network=NETWORK)
    second.load_state_dict(deepcopy(first.state_dict()))  # as through a file: torch shares tensors otherwise
    np.testing.assert_array_equal(first.rewards(windows(9, 2)), second.rewards(windows(9, 2)))
    for objective in (first, second):
        torch.manual_seed(3)
        objective.update(windows(64, 4), windows(64, 5), np.random.default_rng(6))
    np.testing.assert_array_equal(first.rewards(windows(9, 2)), second.rewards(windows(9, 2)))


def test_refuses_impossible_settings():
    with pytest.raises(ValueError, match="batch_size.*7"):
        ImitationObjective(batch_size=7)
    with pytest.raises(ValueError, match="share.*0.0"):
        ImitationObjective(share=0.0)
