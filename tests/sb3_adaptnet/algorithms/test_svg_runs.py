"""`adaptnet train --algo svg`: runs, checkpoints, resuming, export."""

import csv
import json

import pytest
import torch
import yaml
from policy_cases import SIZES

from sb3_adaptnet import SVG, hyperparameters, load_policy
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.runs import world_export
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.run_folder import RunFolder
from sb3_adaptnet.runs.saver import restore, snapshot
from sb3_adaptnet.runs.training import build_learner
from sb3_adaptnet.world_model.world_file import read_world, save_world

STOOP = "AdaptNet/Humanoid-Stoop-v0"


@pytest.fixture
def words(walk_base, tiny_world, tmp_path):
    entry = {
        "policy": "sb3_adaptnet.AdaptNetPolicy", "n_envs": 6, "n_timesteps": 96, "n_steps": 8, "window": 4,
        "gradient_steps": 1, "regression_updates": 1, "model_refresh": {"updates": 1, "batch": 8},
        "cost_to_go": {"updates": [3, 1]}, "policy_kwargs": {"base": str(walk_base)},
    }  # fmt: skip
    conf = tmp_path / "tiny.yml"
    conf.write_text(yaml.safe_dump({STOOP: entry}))
    world = save_world(tiny_world, tmp_path / "tiny")
    return ["train", STOOP, "--algo", "svg", "--conf-file", str(conf), "--world-model", str(world), "--quiet",
            "--threads", "1", "--run-dir", str(tmp_path / "run")]  # fmt: skip


def test_a_run_is_trained_resumed_and_exported(words, walk_base, tmp_path):
    run = tmp_path / "run"
    assert main(words) == 0
    assert main(["train", "--resume", str(run), "--samples", "144", "--quiet"]) == 0
    with (run / "progress.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["samples"] for row in rows] == ["48", "96", "144"]
    assert all(float(row["tracking_error"]) > 0 and float(row["goal_reward"]) > 0 for row in rows)
    assert main(["export", str(run), "-o", str(tmp_path / "mine.safetensors")]) == 0
    card = json.loads((tmp_path / "mine.json").read_text())
    assert card["training"]["svg"]["window"] == 4
    env = build_learner(RunFolder.open(run).settings, RunFolder.open(run).experiment).model.env
    policy = load_policy(tmp_path / "mine.safetensors", env, base=walk_base)
    assert policy.predict(env.reset())[0].shape == (6, 28)


def test_a_checkpoint_restores_policy_model_and_randomness(words, tmp_path):
    main(words)
    folder = RunFolder.open(tmp_path / "run")
    state = folder.load()
    learner = build_learner(folder.settings, folder.experiment)
    restore(learner.model, None, state)
    again = snapshot(learner.model, None, 0.0)["world"]
    assert again["rng"] == state["world"]["rng"]
    assert all(torch.equal(again["model"][name], tensor) for name, tensor in state["world"]["model"].items())
    assert len(again["optimizer"]["state"]) == len(state["world"]["optimizer"]["state"]) > 0


def test_what_begins_a_training_is_done_once(words, tmp_path, monkeypatch):
    """Killed before the first update, a run has a checkpoint in which the first guess is made already."""
    begun = []
    monkeypatch.setattr(SVG, "_begin", lambda self, *rest: begun.append(self) or 0.0)
    monkeypatch.setattr(SVG, "collect_rollout", lambda self, callback: callback.on_rollout_start())
    main(words)
    state = RunFolder.open(tmp_path / "run").load()
    assert (state["updates"], state["world"]["begun"], len(begun)) == (0, True, 1)
    main(["train", "--resume", str(tmp_path / "run"), "--quiet"])
    assert len(begun) == 1


def test_a_base_from_nothing_is_exported_with_its_world_model(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(world_export, "WORLDS", 16)
    monkeypatch.setattr(world_export, "STEPS", 60)
    entry = {
        "policy": "sb3_adaptnet.PretrainPolicy", "world_model": "new", "n_envs": 6, "n_timesteps": 96, "n_steps": 8,
        "window": 4, "gradient_steps": 1, "regression_updates": 1, "model_refresh": {"updates": 1, "batch": 8},
        "model_fits": {"efforts": {0: 0.002}, "steps": 8, "width": 16}, "guiding": {"gaits": [0.9]},
        "cost_to_go": {"updates": [3, 1]}, "policy_kwargs": SIZES,
    }  # fmt: skip
    walk, conf, run = "AdaptNet/Humanoid-Walk-v0", tmp_path / "tiny.yml", tmp_path / "run"
    conf.write_text(yaml.safe_dump({walk: entry}))
    words = ["train", walk, "--algo", "svg", "--conf-file", str(conf), "--threads", "1", "--quiet"]
    assert main([*words, "--run-dir", str(run)]) == 0
    capsys.readouterr()
    assert main(["export", str(run), "-o", str(tmp_path / "mine.safetensors")]) == 0
    world = tmp_path / "mine.world.safetensors"
    assert capsys.readouterr().out.split() == [str(tmp_path / "mine.safetensors"), str(world)]
    model, card = read_world(world)
    state = RunFolder.open(run).load()["world"]["model"]
    for name, tensor in state.items():  # stored in 8 bits
        torch.testing.assert_close(model.state_dict()[name], tensor, rtol=1e-3, atol=float(tensor.abs().max()) / 250)
    assert card["training"] == {"policies": ["mine"], "samples": 96, "seed": 0} and len(card["errors"]["world"]) == 5


def test_the_entries_that_ship_are_svgs():
    for style in ("GooseStep", "Stoop", "Style"):
        found = hyperparameters(f"AdaptNet/Humanoid-{style}-v0", algo="svg")
        assert found["policy_kwargs"]["base"] == "walk"
        assert found["window"] <= found["n_steps"]
    assert experiment(STOOP, algo="svg").algorithm == "svg"
    assert "window" not in hyperparameters(STOOP)
    with pytest.raises(ValueError, match="no algorithm 'sac'; there are: ppo, svg"):
        hyperparameters(STOOP, algo="sac")


def test_a_base_without_a_world_model_says_where_it_is_looked_for(words, capsys):
    without = [word for word in words if "tiny.world" not in word and word != "--world-model"]
    assert main(without) == 2
    assert "tiny.world.safetensors" in capsys.readouterr().err
