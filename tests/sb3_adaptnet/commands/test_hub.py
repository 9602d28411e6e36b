"""`adaptnet publish`, `pull` and `push`."""

import pytest
from evaluation_cases import save_tiny_adaptation, save_tiny_base
from hub_cases import cached, offline_cache

from sb3_adaptnet.commands.main import main
from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.shipped import pretrained_path
from sb3_adaptnet.weights.weight_file import read_weights

WORLD = str(pretrained_path("walk").with_name("walk.world.safetensors"))

ME = ("--owner", "me", "-o", "OUT", "--no-pictures")


@pytest.fixture
def cache(monkeypatch, tmp_path):
    return offline_cache(monkeypatch, tmp_path / "hub")


def test_what_is_published_is_pulled_and_measured(cache, tmp_path, capsys):
    base = save_tiny_base(tmp_path)
    files = [str(base), str(save_tiny_adaptation(base, "one"))]
    assert main(["publish", *files, "--owner", "me", "-o", str(tmp_path / "out"), "--no-pictures"]) == 0
    assert "adaptnet push " in capsys.readouterr().out
    for name in ("tiny", "one"):
        cached(cache, f"me/{name}", *(tmp_path / "out" / name).iterdir())
    assert main(["pull", "me/one", "-o", str(tmp_path / "got")]) == 0
    names = {file.name for file in (tmp_path / "got").iterdir()}
    assert names == {"one.safetensors", "one.json", "README.md", "tiny.safetensors", "tiny.json"}
    assert read_weights(tmp_path / "got" / "one.safetensors")[1] == read_weights(tmp_path / "one.safetensors")[1]
    (tmp_path / "got" / "one.safetensors").unlink()  # as after a kill
    assert main(["pull", "me/one", "-o", str(tmp_path / "got")]) == 0
    assert {file.name for file in (tmp_path / "got").iterdir()} == names
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "README.md").write_text("mine")
    assert main(["pull", "me/one", "-o", str(tmp_path / "mine")]) == 2
    assert "README.md is there already" in capsys.readouterr().err
    assert [file.read_text() for file in (tmp_path / "mine").iterdir()] == ["mine"]
    assert main(["eval", "hf://me/one", "--seconds", "1", "--threads", "1"]) == 0
    assert "goal reward" in capsys.readouterr().out
    assert main(["eval", "hf://me/one", "--seconds", "1", "--write-card"]) == 2
    assert "adaptnet pull ADDRESS" in capsys.readouterr().err


def test_a_push_without_a_network_says_so_and_leaves_nothing(cache, tmp_path, capsys):
    base = save_tiny_base(tmp_path)
    before = sorted(tmp_path.iterdir())
    assert main(["push", str(base), "hf://me/tiny", "--no-pictures"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("adaptnet push: hf://me/tiny: it failed: ") and error.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["pull", "walk"], "'walk' is no address on the Hub"),
        (["pull", "hf://me/nothing"], "not whole in the local cache, and HF_HUB_OFFLINE is set"),
        (["push", "nothing", "hf://me/x"], "no pretrained weights named 'nothing'"),
        (["push", "walk", "hf://me/x/walk.safetensors"], "a whole repository is pushed; leave out the file"),
        (["push", ".", "hf://me/x", "--license", "mit"], "--license is for weights; . is a folder"),
        (["publish", "walk", "nothing", "--owner", "me", "-o", "OUT"], "no pretrained weights named 'nothing'"),
        (["publish", "walk", "nosuch.safetensors", *ME], "nosuch.safetensors"),
        (["publish", "walk", WORLD, *ME], "holds a world model, no policy"),
        (["publish", "walk", "--owner", "me/you", "-o", "OUT"], "'me/you/walk' is no address on the Hub"),
        (["publish", "walk-stoop", "--owner", "me", "--base-model", "walk", "-o", "OUT", "--no-pictures"], "'walk'"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(cache, tmp_path, capsys, words, complaint):
    assert main([str(tmp_path / "out") if word == "OUT" else word for word in words]) == 2
    error = capsys.readouterr().err
    assert complaint in error and error.count("\n") == 1
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_a_film_in_a_modules_own_environment_is_refused_and_leaves_nothing(cache, tmp_path, capsys):
    amend_card(file := save_tiny_base(tmp_path), environment="my_envs:AdaptNet/Humanoid-Dunes-v0")
    words = ["publish", str(file), "--owner", "me", "-o", str(tmp_path / "out")]
    assert main(words) == 2
    assert "a module's own, which would run for picture and film; leave them out" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    assert main([*words, "--no-pictures"]) == 0 and (tmp_path / "out" / "tiny" / "README.md").is_file()
