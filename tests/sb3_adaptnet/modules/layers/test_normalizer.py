"""Running statistics against those of all samples."""

import numpy as np
import pytest
import torch

from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer, moments_of


def test_normalizer_statistics_equal_those_of_all_samples():
    data = np.random.default_rng(0).normal(3.0, 2.0, (1000, 4, 5)).astype(np.float32)
    normalizer = RunningNormalizer(5)
    for start in range(0, 1000, 130):
        normalizer.observe(moments_of(torch.from_numpy(data[start : start + 130])))
    flat = data.reshape(-1, 5).astype(np.float64)
    assert normalizer.count == 4000
    assert np.allclose(normalizer.running_mean, flat.mean(0), atol=1e-6)
    assert np.allclose(normalizer.running_var, flat.var(0), atol=1e-5)


def test_normalizer_moves_only_when_applied_but_takes_the_first_batch_at_once():
    normalizer = RunningNormalizer(2)
    normalizer.observe(moments_of(torch.tensor([[1.0, 0.0], [3.0, 4.0]])))
    assert torch.allclose(normalizer.mean, torch.tensor([2.0, 2.0]))
    before = normalizer(torch.ones(1, 2))
    normalizer.observe(moments_of(torch.randn(100, 2) * 9))
    assert torch.equal(normalizer(torch.ones(1, 2)), before)
    normalizer.apply_statistics()
    assert not torch.equal(normalizer(torch.ones(1, 2)), before)


def test_normalizer_clamps_to_five_standard_deviations_and_survives_constants():
    normalizer = RunningNormalizer(2)
    normalizer.observe(moments_of(torch.tensor([[1.0, 7.0], [3.0, 7.0]])))
    assert normalizer(torch.tensor([[1000.0, 7.0], [-1000.0, 1e6]])).tolist() == [[5.0, 0.0], [-5.0, 5.0]]


def test_copied_statistics_can_still_move():
    base = RunningNormalizer(1)
    base.observe(moments_of(torch.randn(4000, 1)))
    base.count.fill_(1e9)
    own = RunningNormalizer(1)
    own.start_at(base, 1000)
    assert torch.equal(own.mean, base.mean)
    own.observe(moments_of(torch.randn(1000, 1) + 10))
    own.apply_statistics()
    assert own.mean.item() == pytest.approx(5.0, abs=0.3)
