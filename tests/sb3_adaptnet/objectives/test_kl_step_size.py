"""The actor's step size follows the KL divergence."""

import pytest

from sb3_adaptnet.objectives.kl_step_size import next_step_size


def test_the_step_size_follows_the_kl():
    bounds, kl_range = (1e-5, 1e-3), (0.012, 0.03)
    assert next_step_size(1e-4, 0.02, kl_range, bounds) == 1e-4
    assert next_step_size(1e-4, 0.04, kl_range, bounds) == pytest.approx(1e-4 / 1.5)
    assert next_step_size(1e-4, 0.01, kl_range, bounds) == pytest.approx(1.5e-4)
    assert next_step_size(1e-4, float("nan"), kl_range, bounds) == pytest.approx(1e-4 / 1.5)
    assert next_step_size(1e-3, 0.0, kl_range, bounds) == 1e-3
    assert next_step_size(1e-5, 9.0, kl_range, bounds) == 1e-5
