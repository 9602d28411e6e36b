"""The actor's step size follows the KL divergence."""

import pytest

from sb3_adaptnet.objectives.kl_step_size import check_kl_range, kl_range_at, next_step_size


def test_the_step_size_follows_the_kl():
    bounds, kl_range = (1e-5, 1e-3), (0.012, 0.03)
    assert next_step_size(1e-4, 0.02, kl_range, bounds) == 1e-4
    assert next_step_size(1e-4, 0.04, kl_range, bounds) == pytest.approx(1e-4 / 1.5)
    assert next_step_size(1e-4, 0.01, kl_range, bounds) == pytest.approx(1.5e-4)
    assert next_step_size(1e-4, float("nan"), kl_range, bounds) == pytest.approx(1e-4 / 1.5)
    assert next_step_size(1e-3, 0.0, kl_range, bounds) == 1e-3
    assert next_step_size(1e-5, 9.0, kl_range, bounds) == 1e-5


def test_each_bound_of_the_range_may_change_with_the_samples():
    kl_range = ({0: 0.05, 2_000_000: 0.01}, {1_000_000: 0.1, 2_000_000: 0.02})
    check_kl_range(kl_range)
    assert kl_range_at(kl_range, 0) == pytest.approx((0.05, 0.1))
    assert kl_range_at(kl_range, 1_500_000) == pytest.approx((0.02, 0.06))
    assert kl_range_at(kl_range, 9_000_000) == pytest.approx((0.01, 0.02))
    assert kl_range_at((0.01, {0: 0.1, 10: 0.05}), 5) == pytest.approx((0.01, 0.075))


@pytest.mark.parametrize(
    ("kl_range", "complaint"),
    [
        ((0.03, 0.012), r"kl_range.*ascending.*0\.03.*0\.012"),
        ((0.0, 0.1), "kl_range.*positive"),
        (({0: 0.01, 100: 0.06}, 0.05), r"kl_range.*0\.06, 0\.05.*at 100 samples"),
        (("wide", 0.1), "kl_range.*'wide'"),
        (({}, 0.1), "kl_range.*{}"),
    ],
)
def test_a_range_that_is_none_is_refused(kl_range, complaint):
    with pytest.raises(ValueError, match=complaint):
        check_kl_range(kl_range)
