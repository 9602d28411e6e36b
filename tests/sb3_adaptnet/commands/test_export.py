"""What `adaptnet export` writes into a card, and what it refuses."""

import json
from dataclasses import replace

import numpy as np
import pytest

from sb3_adaptnet import AdaptNetPolicy
from sb3_adaptnet.commands.export import card_of, export_onnx, means_of, public_path, task_of
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.run_folder import RunFolder, RunSettings
from sb3_adaptnet.runs.training import make_worlds


@pytest.mark.parametrize("name, seed", [("TerrainHills", 5), ("Obstacles", 5), ("Walk", None)])
def test_the_card_names_the_terrain_that_was_trained_on(tmp_path, name, seed):
    settings = RunSettings(f"AdaptNet/Humanoid-{name}-v0", samples=1, seed=4, n_envs=1, threads=1)
    entry = experiment(settings.env_id)
    worlds = make_worlds(replace(settings, n_envs=1), entry)
    card = card_of(RunFolder(tmp_path, settings), entry, 10, task_of(worlds))
    assert card["training"].get("terrain_seed") == seed and card["training"]["seed"] == 4
    worlds.close()


def test_the_card_names_what_the_worlds_were_asked_for(tmp_path):
    settings = RunSettings("AdaptNet/Humanoid-Walk-v0", samples=1, n_envs=1, threads=1)
    asked = experiment(settings.env_id)
    card = card_of(RunFolder(tmp_path, settings), asked, 10, None)
    assert card["training"]["env_kwargs"] == {"speed_range": [0.4, 1.5]}
    card = card_of(RunFolder(tmp_path, settings), replace(asked, env_kwargs={}), 10, None)
    assert "env_kwargs" not in card["training"]


def test_means_say_over_how_many_rollouts_they_are():
    rows = [{"samples": n, "goal_reward": 0.1 * n, "falls_per_minute": 2.0} for n in range(4)]
    assert means_of(rows) == {"rollouts": 4, "goal_reward": 0.15, "falls_per_minute": 2.0}
    assert means_of([*rows, {"samples": 5, "goal_reward": 0.4}]) == {"rollouts": 5, "goal_reward": 0.2}
    assert means_of([]) == {}


def test_classes_are_named_by_their_public_path():
    assert public_path(AdaptNetPolicy) == "sb3_adaptnet.AdaptNetPolicy"
    assert public_path(Backbone) == "sb3_adaptnet.modules.backbone.Backbone"


@pytest.mark.parametrize(
    ("policies", "words"),
    [
        (["walk-stoop"], "'walk-stoop' is an adaptation; name its base first"),
        (["walk", "walk-stoop=much"], "'much' is not a weight"),
        (["run", "walk-stoop"], "adapts base 'walk'"),
        (["walk", "walk-nothing"], "no pretrained weights named 'walk-nothing'"),
        (["."], "'.' is a folder; export a run to mine.safetensors first"),
    ],
)
def test_bad_wishes_get_one_sentence_and_no_file(policies, words, tmp_path, capsys):
    assert main(["export", *policies, "-o", str(tmp_path / "x.onnx")]) == 2
    printed = capsys.readouterr().err
    assert words in printed and printed.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_only_onnx_takes_several_policies(tmp_path, capsys):
    assert main(["export", "walk", "walk-stoop", "-o", str(tmp_path / "x.safetensors")]) == 2
    assert "does not end in .onnx" in capsys.readouterr().err


def test_default_strengths_share_what_is_left(tmp_path):
    onnx = pytest.importorskip("onnx", reason="the extra [onnx] is not installed")
    file = export_onnx(["walk", "walk-stoop", "walk-penguin=0.7"], tmp_path / "x.onnx")
    values = {entry.key: entry.value for entry in onnx.load(file).metadata_props}
    assert np.allclose(json.loads(values["default_strengths"]), [0.3, 0.7])
