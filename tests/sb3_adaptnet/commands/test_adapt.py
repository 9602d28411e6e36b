"""`adaptnet adapt`: a motion file to a style controller, with tiny networks and few samples."""

import json
import shutil

import pytest
from evaluation_cases import save_tiny_base
from made_up_motions import bvh_text, write
from world_cases import CHARACTER

from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.library import load_clip
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.world_file import save_world


@pytest.fixture
def base(tmp_path):
    return save_tiny_base(tmp_path)


def small(base, tmp_path, **more):
    words = {"--base": base, "-o": tmp_path / "mine.safetensors", "--run-dir": tmp_path / "run"}
    words |= {"--samples": 128, "--n-envs": 8, "--threads": 1, "--seconds": 1, **more}
    return ["adapt", "--quiet", *(str(part) for pair in words.items() for part in pair)]


def test_a_bvh_becomes_a_controller_that_can_be_measured(base, tmp_path, capsys):
    motion = write(tmp_path, "stroll.bvh", bvh_text())
    assert main(small(base, tmp_path, **{"--motion": motion})) == 0
    printed = capsys.readouterr().out
    assert f"adaptnet eval {tmp_path / 'mine.safetensors'}" in printed
    clip = MotionClip.load(tmp_path / "run" / "motion.npz")
    assert clip.cyclic and clip.name == "stroll"
    card = json.loads((tmp_path / "mine.json").read_text())
    assert card["environment"] == "AdaptNet/Humanoid-Style-v0" and card["clip_hash"] == clip.digest
    assert card["training"]["samples"] >= 128
    words = ["--seconds", "1", "--threads", "1", "--json"]
    assert main(["eval", str(tmp_path / "mine.safetensors"), *words]) == 0
    here = json.loads(capsys.readouterr().out)
    measured = card["evaluation"]
    assert {**measured["figures"], "seconds": measured["seconds"], "seed": measured["seed"]} == here
    assert measured["command"] == "adaptnet eval mine.safetensors --seed 0 --seconds 1.3333 --base tiny.safetensors"
    # The clip lies beside the weights: they can be given away, and the run deleted.
    shutil.rmtree(tmp_path / "run")
    there = tmp_path / "elsewhere"
    there.mkdir()
    for file in (*tmp_path.glob("mine.*"), *tmp_path.glob(f"{base.stem}.*")):
        shutil.move(file, there)
    assert {file.name for file in there.glob("mine.*")} == {"mine.safetensors", "mine.json", "mine.motion.npz"}
    assert main(["eval", str(there / "mine.safetensors"), *words]) == 0
    assert json.loads(capsys.readouterr().out) == here


def test_a_run_goes_on_where_it_stopped(base, tmp_path, capsys):
    assert main(small(base, tmp_path, **{"--motion": "Stoop"})) == 0
    first = json.loads((tmp_path / "mine.json").read_text())
    assert first["clip_hash"] == load_clip("Stoop").digest
    assert main(small(base, tmp_path, **{"--motion": "Stoop"})) == 2
    assert "--resume" in capsys.readouterr().err
    again = ["adapt", "--resume", str(tmp_path / "run"), "--samples", "256", "-o", str(tmp_path / "more"), "--quiet"]
    again += ["--seconds", "1"]
    for option in (["--motion", "Limp"], ["--seed", "3"], ["--base", "walk"]):
        assert main([*again, *option]) == 2
        assert f"{option[0]} cannot change in a resumed run" in capsys.readouterr().err
    assert main(again) == 0
    second = json.loads((tmp_path / "more.json").read_text())
    assert second["training"]["samples"] >= 256 and second["hash"] != first["hash"]


def test_a_base_with_a_world_model_is_adapted_through_it(base, tmp_path, capsys):
    save_world(WorldModel(CHARACTER, Sizes(8, 1)), base.with_suffix(""))
    assert main(small(base, tmp_path, **{"--motion": "Stoop"})) == 0
    assert json.loads((tmp_path / "mine.json").read_text())["training"]["svg"]["window"] == 16
    again = {"--motion": "Stoop", "--run-dir": tmp_path / "again", "-o": tmp_path / "again.safetensors"}
    assert main(small(base, tmp_path, **again, **{"--algo": "ppo"})) == 0
    assert "svg" not in json.loads((tmp_path / "again.json").read_text())["training"]
    capsys.readouterr()
    assert main(small(base, tmp_path, **again, **{"--algo": "ppo", "--world-model": "any.safetensors"})) == 2
    assert "goes with --algo svg, not with ppo" in capsys.readouterr().err


@pytest.mark.parametrize(
    "more, complaint",
    [
        ({}, "--motion"),
        ({"--motion": "Moonwalk"}, "Moonwalk"),
        ({"--motion": "missing.bvh"}, "no such file"),
        ({"--motion": "Stoop", "--map": "map.yml"}, "a map is for BVH files"),
        ({"--motion": "Stoop", "-o": "no/such/folder/mine"}, "does not exist"),
        ({"--motion": "Stoop", "--algo": "svg", "--world-model": "no.safetensors"}, "no weights file 'no.safetensors'"),
    ],
)
def test_bad_input_is_one_sentence_and_nothing_is_written(base, tmp_path, capsys, more, complaint):
    assert main(small(base, tmp_path, **more)) == 2
    printed = capsys.readouterr()
    assert complaint in printed.err and printed.err.count("\n") == 1
    assert not (tmp_path / "run").exists()
