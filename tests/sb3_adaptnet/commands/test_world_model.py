"""`adaptnet world-model`: a model is fitted, says what it was fitted to, and is measured."""

import json

import cv2
import pytest
from world_cases import CHARACTER

from sb3_adaptnet.commands import world_model
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.world_file import save_world


def test_a_model_is_fitted_and_measured(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(world_model, "EVAL_WORLDS", 8)
    monkeypatch.setattr(world_model, "EVAL_STEPS", 80)
    file = tmp_path / "walk.world.safetensors"
    words = ["--worlds", "40", "--steps", "60", "--effort", "0.001", "--threads", "1", "--policies", "walk-stoop"]
    assert main(["world-model", "fit", "walk", "-o", str(file), *words]) == 0
    shown = capsys.readouterr().out
    assert "after 1 updates of 8 steps" in shown
    assert f"wrote {file}" in shown
    card = json.loads(file.with_suffix(".json").read_text())
    assert card["environment"] == "AdaptNet/Humanoid-Walk-v0"
    assert card["training"]["policies"] == ["walk", "walk-stoop"]
    assert card["errors"]["steps"] == [1, 4, 8, 16, 32]
    assert main(["world-model", "eval", str(file), "--threads", "1"]) == 0
    first = capsys.readouterr().out
    assert "steps ahead                1       4       8      16      32" in first
    picture = tmp_path / "errors.png"
    assert main(["world-model", "eval", str(file), "--threads", "1", "-o", str(picture)]) == 0
    assert capsys.readouterr().out == f"{first}wrote {picture}\n"
    assert (cv2.imread(str(picture)).std(axis=2) > 20).any()  # there are coloured lines
    hills = "AdaptNet/Humanoid-TerrainHills-v0"
    assert main(["world-model", "eval", str(file), "--env", hills]) == 2
    assert f"{hills} has uneven ground" in capsys.readouterr().err
    assert main(["world-model", "eval", "nothing.safetensors", "-o", str(tmp_path / "errors.txt")]) == 2
    assert "must be .png" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("about", "words"),
    [
        ({"environment": "evil:AdaptNet/Humanoid-Walk-v0", "training": {"policies": ["walk"]}}, "a module's own"),
        ({"training": {"policies": ["walk"]}}, "does not say what it was trained in"),
        ({"environment": "AdaptNet/Humanoid-Walk-v0", "training": {"policies": ["hf://a/b"]}}, "name a policy with"),
        ({"environment": "AdaptNet/Humanoid-Walk-v0"}, "was fitted to None; name a policy with --policy"),
    ],
)
def test_a_card_makes_nothing_be_imported_or_fetched(about, words, tmp_path, capsys):
    file = save_world(WorldModel(CHARACTER, Sizes(8, 1)), tmp_path / "walk", **about)
    assert main(["world-model", "eval", str(file)]) == 2
    assert words in capsys.readouterr().err


def test_fits_that_cannot_be_are_refused_before_anything_is_recorded(tmp_path, capsys):
    words = ["world-model", "fit", "walk", "-o", str(tmp_path / "walk.world.safetensors")]
    assert main([*words, "--worlds", "5"]) == 2
    assert "5 worlds are too few" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main([*words, "--effort", "-1"])
    assert "'-1' is not a positive factor" in capsys.readouterr().err


def test_a_model_of_other_joints_is_not_measured(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(world_model, "EVAL_WORLDS", 2)
    monkeypatch.setattr(world_model, "EVAL_STEPS", 2)
    about = {"environment": "AdaptNet/Humanoid-Walk-v0", "training": {"policies": ["walk"]}}
    file = save_world(WorldModel(CHARACTER, Sizes(8, 1)), tmp_path / "walk", **about)
    assert main(["world-model", "eval", str(file), "--env", "AdaptNet/Humanoid-LockedElbowsWalk-v0"]) == 2
    assert "other joints" in capsys.readouterr().err
