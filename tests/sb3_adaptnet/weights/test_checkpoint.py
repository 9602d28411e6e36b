"""Weights files: exact round trips, one clear sentence for everything else."""

import json
import pickle
import re

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file
from stable_baselines3 import PPO
from torch import nn
from toy_env import ToyEnv, ToyVectorEnv

from sb3_adaptnet import (
    AdaptNetPolicy,
    CheckpointError,
    FinetunePolicy,
    PretrainPolicy,
    ProgressivePolicy,
    load_policy,
    save_adaptation,
    save_base,
)
from sb3_adaptnet.weights.shipped import pretrained_path, zoo_config_path

ENV = ToyEnv()
OBSERVATIONS = np.random.default_rng(0).normal(0, 0.5, (5, 784)).astype(np.float32)
ARGUMENTS = {"n_steps": 32, "batch_size": 16, "n_epochs": 1, "device": "cpu"}


def act(policy):
    return policy.predict(OBSERVATIONS, deterministic=True)[0]


@pytest.fixture(scope="module")
def base_model():
    model = PPO(PretrainPolicy, ENV, policy_kwargs={"gru_size": 8, "hidden_sizes": (16, 12)}, **ARGUMENTS)
    nn.init.normal_(model.policy.actor.mean.weight, std=0.3)
    return model.learn(32)


@pytest.fixture
def base_file(base_model, tmp_path):
    return save_base(base_model, tmp_path / "tiny", clip_hash="abc", metrics={"goal_reward": 0.5}, training={"seed": 1})


@pytest.fixture
def adaptation_file(base_file, tmp_path):
    model = PPO(AdaptNetPolicy, ENV, policy_kwargs={"base": str(base_file)}, **ARGUMENTS)
    with torch.no_grad():
        for parameter in model.policy.actor.adaptations.parameters():
            parameter.add_(torch.randn_like(parameter) * 0.1)
    return save_adaptation(model, tmp_path / "stoop", environment="Toy-v0")


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
    with pytest.raises(ValueError, match="save_base"):
        save_adaptation(model, tmp_path / "tuned2")


def test_progressive_column_round_trip(base_file, tmp_path):
    model = PPO(ProgressivePolicy, ENV, policy_kwargs={"base": str(base_file)}, **ARGUMENTS).learn(32)
    file = save_adaptation(model, tmp_path / "column")
    assert np.array_equal(act(load_policy(file, ENV)), act(model.policy))


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


# -- files that are not right --------------------------------------------------------------------------------------


def rewrite(file, change_tensors=lambda tensors: tensors, change_card=lambda card: card):
    with safe_open(file, framework="pt") as opened:
        tensors = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118
        card = json.loads(opened.metadata()["adaptnet"])
    save_file(change_tensors(tensors), file, metadata={"adaptnet": json.dumps(change_card(card))})


def cut(file):
    file.write_bytes(file.read_bytes()[:-100])


def cut_header(file):
    file.write_bytes(file.read_bytes()[:20])


def empty(file):
    file.write_bytes(b"")


def text(file):
    file.write_text("hello")


def foreign(file):
    save_file({"weight": torch.zeros(3)}, file)


def flipped_bit(file):
    content = bytearray(file.read_bytes())
    content[-5] ^= 1
    file.write_bytes(bytes(content))


def other_format(file):
    rewrite(file, change_card=lambda card: card | {"format": 99})


def other_kind(file):
    rewrite(file, change_card=lambda card: card | {"kind": "sandwich"})


def other_observation(file):
    rewrite(file, change_card=lambda card: card | {"observation_version": 7})


def card_not_json(file):
    save_file({"weight": torch.zeros(3)}, file, metadata={"adaptnet": "{"})


def card_a_list(file):
    save_file({"weight": torch.zeros(3)}, file, metadata={"adaptnet": "[1]"})


def missing(file):
    file.unlink()


DAMAGES = {
    cut: "cut or is not a safetensors file",
    cut_header: "cut or is not a safetensors file",
    empty: "cut or is not a safetensors file",
    text: "cut or is not a safetensors file",
    foreign: "no AdaptNet card",
    flipped_bit: "damaged",
    other_format: "format 99",
    other_kind: "sandwich",
    other_observation: "version 7",
    card_not_json: "not JSON",
    card_a_list: "format None",
    missing: "no weights file",
}


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
def test_wrong_files_give_one_clear_sentence(damage, base_file):
    damage(base_file)
    with pytest.raises(CheckpointError, match=DAMAGES[damage]) as error:
        load_policy(base_file, ENV)
    assert "\n" not in str(error.value)
    assert base_file.name in str(error.value)


def test_card_that_does_not_fit_the_weights(base_file):
    card = json.loads(base_file.with_suffix(".json").read_text())
    rewrite(base_file, change_card=lambda card: card | {"architecture": card["architecture"] | {"gru_size": 9}})
    with pytest.raises(CheckpointError, match="damaged"):
        load_policy(base_file, ENV)
    assert card["architecture"]["gru_size"] == 8


def test_weights_that_are_not_finite_are_refused(base_model, tmp_path):
    policy = load_policy(save_base(base_model, tmp_path / "a"), ENV)
    with torch.no_grad():
        policy.actor.mean.bias[0] = float("nan")
    file = save_base(policy, tmp_path / "b")
    with pytest.raises(CheckpointError, match="finite"):
        load_policy(file, ENV)


class Bomb:
    def __reduce__(self):
        return (exec, ("raise SystemExit('code ran')",))


@pytest.mark.parametrize("suffix", [".safetensors", ".zip", ".pt"])
def test_opening_a_pickle_runs_nothing(suffix, tmp_path):
    file = tmp_path / f"bomb{suffix}"
    file.write_bytes(pickle.dumps(Bomb()))
    with pytest.raises(CheckpointError, match="not a safetensors file"):
        load_policy(file, ENV)


def test_base_where_an_adaptation_is_wanted(base_file, adaptation_file):
    policy = load_policy(adaptation_file, ENV)
    with pytest.raises(CheckpointError, match="holds 'base', not 'adaptation'"):
        policy.add_adaptation(base_file)
    with pytest.raises(CheckpointError, match="holds 'adaptation', not 'base'"):
        PPO(AdaptNetPolicy, ENV, policy_kwargs={"base": str(adaptation_file)}, **ARGUMENTS)


def test_unknown_names_list_the_known():
    with pytest.raises(CheckpointError, match="moonwalk"):
        load_policy("moonwalk", ENV)
    with pytest.raises(ValueError, match="moonwalk"):
        pretrained_path("moonwalk")
    with pytest.raises(ValueError, match="moonwalk"):
        zoo_config_path("moonwalk")
