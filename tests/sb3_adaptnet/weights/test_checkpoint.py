"""Bases and adaptations as files: exact round trips, what a card says."""

import copy
import json
import re

import numpy as np
import pytest
import torch
from safetensors import safe_open
from stable_baselines3 import PPO
from toy_env import ToyEnv, ToyVectorEnv
from weight_cases import ARGUMENTS, ENV, OBSERVATIONS, act

from sb3_adaptnet import (
    AdaptNetPolicy,
    CheckpointError,
    FinetunePolicy,
    ProgressivePolicy,
    load_policy,
    save_adaptation,
    save_base,
)
from sb3_adaptnet.policies.loading import load_base_of
from sb3_adaptnet.weights.checkpoint import read_base


def test_base_round_trip_is_exact_also_right_after_training(base_model, base_file):
    assert np.array_equal(act(load_policy(base_file, ENV)), act(base_model.policy))


def test_base_card_describes_it(base_file):
    card = json.loads(base_file.with_suffix(".json").read_text())
    with safe_open(base_file, framework="pt") as opened:
        assert json.loads(opened.metadata()["adaptnet"]) == card
    assert card["kind"] == "base"
    assert card["architecture"]["hidden_sizes"] == [16, 12]
    assert card["architecture"]["joints"] == list(ENV.action_space.joint_names)
    assert card["observation_version"] == 1
    assert (card["clip_hash"], card["metrics"], card["training"]) == ("abc", {"goal_reward": 0.5}, {"seed": 1})
    assert re.fullmatch("[0-9a-f]{64}", card["hash"])


def test_loaded_policy_takes_single_and_vector_environments(base_file):
    single, vector = load_policy(base_file, ENV), load_policy(base_file, ToyVectorEnv(3))
    assert np.array_equal(act(single), act(vector))
    assert single.predict(OBSERVATIONS[0], deterministic=True)[0].shape == (28,)


def test_adaptation_holds_only_its_own_weights_and_names_its_base(base_file, adaptation_file):
    with safe_open(adaptation_file, framework="pt") as opened:
        names = list(opened.keys())
        card = json.loads(opened.metadata()["adaptnet"])
    assert {name.split(".")[0] for name in names} == {"injector", "adaptors"}
    assert card["base"] == {"name": "tiny", "hash": json.loads(base_file.with_suffix(".json").read_text())["hash"]}
    assert card["shape"]["injection"] == "z0"
    assert card["environment"] == "Toy-v0"


def test_adaptation_finds_the_base_beside_it(adaptation_file, base_file, tmp_path):
    beside = load_policy(adaptation_file, ENV)
    moved = tmp_path / "elsewhere" / "stoop.safetensors"
    moved.parent.mkdir()
    adaptation_file.rename(moved)
    assert np.array_equal(act(load_policy(moved, ENV, base=base_file)), act(beside))
    with pytest.raises(CheckpointError, match=r"base 'tiny'.*base=\.\.\."):
        load_policy(moved, ENV)


def test_finetuned_policy_becomes_a_base_of_its_own(base_file, tmp_path):
    model = PPO(FinetunePolicy, ENV, policy_kwargs={"base": str(base_file)}, **ARGUMENTS).learn(32)
    file = save_base(model, tmp_path / "tuned")
    assert np.array_equal(act(load_policy(file, ENV)), act(model.policy))
    assert np.array_equal(act(load_base_of(file, ENV)), act(load_policy(base_file, ENV)))
    assert load_base_of(base_file, ENV) is None
    with pytest.raises(ValueError, match="save_base"):
        save_adaptation(model, tmp_path / "tuned2")


def test_progressive_column_round_trip(base_file, tmp_path):
    model = PPO(ProgressivePolicy, ENV, policy_kwargs={"base": str(base_file)}, **ARGUMENTS).learn(32)
    file = save_adaptation(model, tmp_path / "column")
    assert np.array_equal(act(load_policy(file, ENV)), act(model.policy))


def test_half_precision_takes_half_the_room_and_computes_in_single(base_model, base_file, tmp_path):
    half = save_base(base_model, tmp_path / "half", bits=16)
    assert half.stat().st_size < 0.65 * base_file.stat().st_size
    short, full = (read_base(file).backbone.state_dict() for file in (half, base_file))
    for name, weights in full.items():
        assert short[name].dtype == weights.dtype
        torch.testing.assert_close(short[name], weights, rtol=1e-3, atol=1e-7)
    policy = copy.deepcopy(base_model.policy)
    with torch.no_grad():
        policy.actor.mean.bias[0] = 1e6
    with pytest.raises(ValueError, match="mean.bias has numbers beyond half precision, as 1e\\+06"):
        save_base(policy, tmp_path / "beyond", bits=16)
    assert not list(tmp_path.glob("beyond*"))


def test_adapted_policy_is_not_a_base(adaptation_file, tmp_path):
    with pytest.raises(ValueError, match="save_adaptation"):
        save_base(load_policy(adaptation_file, ENV), tmp_path / "x")


def test_heightmap_adaptation_needs_a_heightmap(base_file, tmp_path):
    env = ToyEnv(heightmap=True)
    model = PPO(AdaptNetPolicy, env, policy_kwargs={"base": str(base_file)}, **ARGUMENTS)
    file = save_adaptation(model, tmp_path / "rough")
    assert load_policy(file, env).actor.parts()["main"].injector.heightmap is not None
    with pytest.raises(ValueError, match="heightmap"):
        load_policy(file, ENV)


def test_saving_again_replaces_the_whole_file(base_model, base_file):
    before = sorted(base_file.parent.iterdir())
    save_base(base_model, base_file, metrics={"goal_reward": 0.9})
    assert sorted(base_file.parent.iterdir()) == before
    assert json.loads(base_file.with_suffix(".json").read_text())["metrics"] == {"goal_reward": 0.9}


def test_failed_write_leaves_the_old_file_and_no_rubbish(base_model, base_file):
    content, names = base_file.read_bytes(), sorted(base_file.parent.iterdir())
    with pytest.raises(TypeError):
        save_base(base_model, base_file, metrics={"not JSON": object()})
    assert base_file.read_bytes() == content
    assert sorted(base_file.parent.iterdir()) == names


def test_reserved_card_entries_are_refused(base_model, tmp_path):
    with pytest.raises(ValueError, match="architecture"):
        save_base(base_model, tmp_path / "x", architecture={})


def test_base_where_an_adaptation_is_wanted(base_file, adaptation_file):
    policy = load_policy(adaptation_file, ENV)
    with pytest.raises(CheckpointError, match="holds 'base', not 'adaptation'"):
        policy.add_adaptation(base_file)
    with pytest.raises(CheckpointError, match="holds 'adaptation', not 'base'"):
        PPO(AdaptNetPolicy, ENV, policy_kwargs={"base": str(adaptation_file)}, **ARGUMENTS)
