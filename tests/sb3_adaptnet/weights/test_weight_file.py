"""Files that are not right: one clear sentence for each."""

import json
import pickle

import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file
from weight_cases import ENV

from sb3_adaptnet import (
    CheckpointError,
    load_policy,
    save_base,
)
from sb3_adaptnet.weights.checkpoint import build_checked


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


@pytest.mark.parametrize("size", [10**15, -4])
def test_sizes_that_no_memory_holds(size, tmp_path):
    with pytest.raises(CheckpointError, match="the card of 'a' does not describe a network"):
        build_checked("a", {}, lambda: torch.nn.Linear(size, 2))


def test_weights_that_are_not_finite_are_refused(base_model, tmp_path):
    policy = load_policy(save_base(base_model, tmp_path / "a"), ENV)
    with torch.no_grad():
        policy.actor.mean.bias[0] = float("nan")
    file = save_base(policy, tmp_path / "b")
    with pytest.raises(CheckpointError, match="finite"):
        load_policy(file, ENV)


@pytest.mark.parametrize("content", ['{"joints": []}', "[1, 2]", "not JSON"])
def test_a_card_replaces_cards_alone(base_model, tmp_path, content):
    file = save_base(base_model, tmp_path / "a")
    save_base(base_model, file)  # its own card
    before = file.read_bytes()
    file.with_suffix(".json").write_text(content)
    for name in (file, tmp_path / "a"):
        with pytest.raises(ValueError, match="a.json is there already and is no card of weights"):
            save_base(base_model, name)
    assert file.with_suffix(".json").read_text() == content and file.read_bytes() == before


class Bomb:
    def __reduce__(self):
        return (exec, ("raise SystemExit('code ran')",))


@pytest.mark.parametrize("suffix", [".safetensors", ".zip", ".pt"])
def test_opening_a_pickle_runs_nothing(suffix, tmp_path):
    file = tmp_path / f"bomb{suffix}"
    file.write_bytes(pickle.dumps(Bomb()))
    with pytest.raises(CheckpointError, match="not a safetensors file"):
        load_policy(file, ENV)
