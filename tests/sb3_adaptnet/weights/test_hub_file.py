"""Policies by their address on the Hub: from its cache, without a network."""

import numpy as np
import pytest
from hub_cases import COMMIT, cached, offline_cache
from weight_cases import ENV, act

from sb3_adaptnet import CheckpointError, load_policy
from sb3_adaptnet.weights.checkpoint import resolve


@pytest.fixture
def cache(monkeypatch, tmp_path):
    return offline_cache(monkeypatch, tmp_path / "hub")


def model_card(folder, base_model):
    (folder / "README.md").write_text(f"---\nbase_model: {base_model}\n---\n")


def test_a_base_from_the_cache_acts_as_the_file_does(cache, base_file):
    cached(cache, "someone/tiny", base_file)
    assert np.array_equal(act(load_policy("hf://someone/tiny", ENV)), act(load_policy(base_file, ENV)))


@pytest.mark.parametrize("address", ["hf://a/b@v1", f"hf://a/b@{COMMIT}", "hf://a/b@v1/tiny.safetensors"])
def test_revisions_and_files_are_named(cache, base_file, address):
    folder = cached(cache, "a/b", base_file, revision="v1")
    assert resolve(address) == folder / "tiny.safetensors"


def test_an_adaptation_finds_its_base_on_the_hub(cache, base_file, adaptation_file):
    expected = act(load_policy(adaptation_file, ENV))
    model_card(cached(cache, "someone/stoop", adaptation_file), "other/tiny")
    cached(cache, "other/tiny", base_file)
    assert np.array_equal(act(load_policy("hf://someone/stoop", ENV)), expected)


def test_a_shipped_base_with_other_weights_gives_way(cache, base_file, adaptation_file, tiny_base, monkeypatch):
    expected = act(load_policy(adaptation_file, ENV))
    shipped = tiny_base.parent
    monkeypatch.setattr("sb3_adaptnet.weights.shipped._folders", lambda _: (shipped, shipped))
    model_card(cached(cache, "someone/stoop", adaptation_file), "other/tiny")
    with pytest.raises(CheckpointError, match="hf://other/tiny: it is not whole in the local cache"):
        load_policy("hf://someone/stoop", ENV)
    cached(cache, "other/tiny", base_file)
    assert np.array_equal(act(load_policy("hf://someone/stoop", ENV)), expected)


def test_another_base_than_the_one_adapted_is_refused(cache, adaptation_file, tiny_base):
    model_card(cached(cache, "someone/stoop", adaptation_file), "other/tiny")
    cached(cache, "other/tiny", tiny_base)
    with pytest.raises(CheckpointError, match="adapts base 'tiny' \\(hash .* not 'tiny' \\(hash"):
        load_policy("hf://someone/stoop", ENV)


def test_an_adaptation_without_its_base_says_so(cache, adaptation_file):
    cached(cache, "someone/stoop", adaptation_file)
    with pytest.raises(CheckpointError, match="neither beside it .* no model card beside it says where"):
        load_policy("hf://someone/stoop", ENV)


def test_what_is_not_in_the_cache_is_one_sentence(cache):
    with pytest.raises(CheckpointError, match="^hf://someone/else: it is not whole in the local cache, and HF_HUB_OFF"):
        load_policy("hf://someone/else", ENV)


def test_a_repository_holds_one_policy_or_is_asked_for_one(cache, base_file, adaptation_file):
    world = base_file.with_name("tiny.world.safetensors")
    world.write_bytes(b"a world model")
    cached(cache, "a/one", base_file, world)
    assert resolve("hf://a/one").name == "tiny.safetensors"
    cached(cache, "a/two", base_file, adaptation_file)
    with pytest.raises(CheckpointError, match="one weight file is expected, or its name; found .*stoop.*tiny"):
        resolve("hf://a/two")
    with pytest.raises(CheckpointError, match="no such file; .*stoop.*tiny"):
        resolve("hf://a/two/walk.safetensors")
    assert resolve("hf://a/two/stoop.safetensors").name == "stoop.safetensors"


def test_damaged_weights_are_refused(cache, base_file):
    file = cached(cache, "a/b", base_file) / "tiny.safetensors"
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(bytes(content))
    with pytest.raises(CheckpointError, match="damaged"):
        load_policy("hf://a/b", ENV)


def test_a_bad_address_is_refused():
    with pytest.raises(CheckpointError, match="'hf://walk' is no address on the Hub"):
        load_policy("hf://walk", ENV)
