"""Groups with their own step sizes."""

import pytest
import torch
from stable_baselines3.common.utils import update_learning_rate

from sb3_adaptnet.policies.optimizer_groups import group_named, make_groups, set_step_size, step_size
from sb3_adaptnet.policies.scaled_adam import ScaledAdam


def networks():
    critic = torch.nn.Linear(2, 2)
    critic.bias.requires_grad_(False)
    return {"actor": torch.nn.Linear(3, 1), "critic": critic}


def test_groups_hold_what_learns_and_step_as_asked():
    learning = networks()
    optimizer = ScaledAdam(make_groups(learning, {"actor": 5e-6, "critic": None}, 1e-4), lr=1e-4)
    assert step_size(optimizer, "actor") == pytest.approx(5e-6)
    assert step_size(optimizer, "critic") == 1e-4
    assert len(group_named(optimizer, "actor")["params"]) == 2
    assert [p is learning["critic"].weight for p in group_named(optimizer, "critic")["params"]] == [True]


def test_a_step_size_survives_another_learning_rate():
    """It is relative to PPO's: halving `lr` halves it."""
    optimizer = ScaledAdam(make_groups(networks(), {"actor": None, "critic": None}, 1e-3), lr=1e-3)
    set_step_size(optimizer, "actor", 4e-5)
    assert step_size(optimizer, "actor") == pytest.approx(4e-5)
    update_learning_rate(optimizer, 5e-4)
    assert step_size(optimizer, "actor") == pytest.approx(2e-5)
    assert step_size(optimizer, "critic") == 5e-4


def test_nothing_is_scaled_where_nothing_is_to_learn():
    groups = make_groups(networks(), {"actor": 5e-6, "critic": 1e-4}, 0.0)
    assert [group["lr_scale"] for group in groups] == [1.0, 1.0]


def test_unknown_group_lists_the_known_ones():
    optimizer = ScaledAdam([{"params": networks()["critic"].parameters(), "name": "critic"}])
    with pytest.raises(KeyError, match="actor.*critic"):
        group_named(optimizer, "actor")
