"""Cards of weight files that exist: entries come and go, the weights stay."""

import json
import shutil

import pytest
import torch
from policy_cases import act
from toy_env import ToyEnv

from sb3_adaptnet import load_policy
from sb3_adaptnet.weights.card import FIXED, amend_card, trained_in
from sb3_adaptnet.weights.weight_file import CheckpointError, read_weights, write_weights


def weight_bytes(file):
    """What a safetensors file holds behind its header."""
    content = file.read_bytes()
    return content[8 + int.from_bytes(content[:8], "little") :]


@pytest.fixture
def file(tmp_path):
    tensors = {"b": torch.arange(6.0).reshape(2, 3), "a": torch.tensor([1, 2, 3]), "c": torch.zeros(0)}
    write_weights(
        tmp_path / "some.safetensors", tensors, {"kind": "base", "training": {"seed": 1}, "metrics": {"x": 1}}
    )
    return tmp_path / "some.safetensors"


def test_entries_are_written_and_taken_away_and_the_weights_stay(file):
    tensors, before = read_weights(file)
    raw = weight_bytes(file)
    returned = amend_card(file, evaluation={"seed": 3}, metrics=None)
    same, after = read_weights(file)
    assert after == returned == json.loads(file.with_suffix(".json").read_text())
    assert after == {name: value for name, value in before.items() if name != "metrics"} | {"evaluation": {"seed": 3}}
    assert weight_bytes(file) == raw and after["hash"] == before["hash"]
    assert all(torch.equal(same[name], tensors[name]) for name in tensors)
    assert {path.name for path in file.parent.iterdir()} == {"some.safetensors", "some.json"}


@pytest.mark.parametrize("name", FIXED)
def test_what_belongs_to_the_weights_cannot_change(file, name):
    content = file.read_bytes()
    with pytest.raises(ValueError, match=f"'{name}' belongs to the weights"):
        amend_card(file, **{name: "other"})
    assert file.read_bytes() == content


def test_a_damaged_file_is_left_alone(file):
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)
    with pytest.raises(CheckpointError, match="damaged"):
        amend_card(file, evaluation={})
    assert file.read_bytes() == content


def test_a_policy_acts_the_same_before_and_after(tiny_base, tmp_path):
    copy = shutil.copyfile(tiny_base, tmp_path / "copy.safetensors")
    amend_card(copy, evaluation={"seed": 0})
    assert (act(load_policy(copy, ToyEnv())) == act(load_policy(tiny_base, ToyEnv()))).all()


def test_a_card_tells_the_environment_and_the_clip_of_any(file):
    with pytest.raises(ValueError, match="does not say what it was trained in"):
        trained_in(str(file))
    amend_card(file, environment="AdaptNet/Humanoid-IceWalk-v0", motion="Stoop")
    assert trained_in(str(file)) == ("AdaptNet/Humanoid-IceWalk-v0", "Stoop")
    amend_card(file, motion="out/one.npz")  # where it was trained; both may lie elsewhere by now
    assert trained_in(str(file))[1] == "out/one.npz"
    (clip := file.with_name("one.npz")).write_bytes(b"clip")
    assert trained_in(str(file))[1] == str(clip)
    amend_card(file, motion=None)
    assert trained_in(str(file)) == ("AdaptNet/Humanoid-IceWalk-v0", None)


def test_a_card_cannot_name_a_module_to_import(file):
    amend_card(file, environment="evil:AdaptNet/Humanoid-Stoop-v0")
    with pytest.raises(ValueError, match="'evil:AdaptNet/Humanoid-Stoop-v0', a module's own; name it with --env"):
        trained_in(str(file))
