"""Costs-to-go of known chains."""

import pytest
import torch

from sb3_adaptnet.algorithms.rollouts.cost_returns import costs_to_go

NO = (False,) * 4


def column(values):
    return torch.tensor(values)[:, None]


def found(costs, values, ended=NO, failed=NO, trace=1.0):
    result = costs_to_go(
        column(costs), column(values), column(ended), column(failed), discount=0.5, trace=trace, end_cost=100.0
    )
    return result[:, 0]


def test_to_the_end_of_a_rollout_costs_are_summed_up():
    known = found([9.0, 2.0, 4.0, 8.0], [0.0, 0.0, 0.0, 6.0])
    assert known[:3].tolist() == [2 + 4 / 2 + 8 / 4 + 6 / 8, 4 + 8 / 2 + 6 / 4, 8 + 6 / 2]
    assert known[3].isnan()


def test_one_step_trusts_the_critic():
    known = found([9.0, 2.0, 4.0, 8.0], [1.0, 3.0, 5.0, 7.0], trace=0.0)
    assert known[:3].tolist() == [2 + 3 / 2, 4 + 5 / 2, 8 + 7 / 2]


def test_lambda_mixes_the_returns_of_all_lengths():
    costs, values, trace = [9.0, 2.0, 4.0, 8.0], [1.0, 3.0, 5.0, 7.0], 0.9
    after = [2 + 3 / 2, 2 + 4 / 2 + 5 / 4, 2 + 4 / 2 + 8 / 4 + 7 / 8]
    mixed = (1 - trace) * after[0] + (1 - trace) * trace * after[1] + trace**2 * after[2]
    assert float(found(costs, values, trace=trace)[0]) == pytest.approx(mixed)


def test_a_failure_costs_and_another_end_is_left_to_the_critic():
    ended = (False, False, True, False)
    lost = found([9.0, 2.0, 4.0, 8.0], [1.0, 3.0, 5.0, 7.0], ended)
    assert float(lost[0]) == 2 + 3 / 2
    assert lost[1:].isnan().all()
    fell = found([9.0, 2.0, 4.0, 8.0], [1.0, 3.0, 5.0, 7.0], ended, ended)
    assert fell[:2].tolist() == [2 + 50 / 2, 50]
    assert fell[2:].isnan().all()
