"""A run beside companions: what it trains in, what it exports, and that it goes on."""

import json

import numpy as np
import yaml

from adapt_envs import env_id
from sb3_adaptnet import AdaptVecEnv, load_policy
from sb3_adaptnet.commands.export import export
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.runs import RunSettings
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.worlds import make_worlds
from sb3_adaptnet.stacking import JoinedWorlds, part_of
from sb3_adaptnet.weights.shipped import zoo_config_path

ICE = env_id("IceWalk")


def test_the_shipped_companions_are_styles_of_the_base():
    for name, count in (("IceWalk", 5), ("TerrainHills", 9), ("TerrainRugged", 8), ("LongBodyWalk", 12)):
        companions = experiment(env_id(name), conf_file="stackable").arguments["policy_kwargs"]["companions"]
        assert {part_of(companion).kind for companion in companions} == {"style"} and len(set(companions)) == count


def test_a_run_learns_beside_companions_goes_on_and_exports_what_it_learned_alone(tmp_path, capsys):
    entry = yaml.safe_load(zoo_config_path("stackable").read_text())[ICE]
    entry |= {"n_envs": 8, "n_steps": 4, "batch_size": 32, "n_epochs": 1}
    entry["policy_kwargs"] |= {"companions": ["walk-penguin", "walk-limp"], "precision": "fp32"}
    entry["callback"][0]["sb3_adaptnet.DiscriminatorRewardCallback"]["discriminator"]["batch_size"] = 16
    file, run = tmp_path / "small.yml", tmp_path / "run"
    file.write_text(yaml.safe_dump({ICE: entry}))
    assert main(["train", ICE, "--conf-file", str(file), "--samples", "64", "--threads", "1", "--quiet",
                 "--run-dir", str(run)]) == 0  # fmt: skip
    assert main(["train", "--resume", str(run), "--samples", "96", "--quiet"]) == 0
    assert "96 samples" in capsys.readouterr().out
    card = json.loads(export(run, tmp_path / "ice.safetensors").with_suffix(".json").read_text())
    assert card["environment"] == ICE and card["training"]["samples"] == 96
    assert card["training"]["ppo"]["policy_kwargs"]["companions"] == ["walk-penguin", "walk-limp"]
    env = AdaptVecEnv(ICE, 2, num_threads=1, seed=0)
    alone = load_policy(tmp_path / "ice.safetensors", env).predict(env.reset(), deterministic=True)[0]
    assert np.isfinite(alone).all()
    env.close()


def test_svg_learns_beside_companions_goes_on_and_exports(tmp_path, capsys):
    shins = env_id("LongShinsWalk")
    entry = yaml.safe_load(zoo_config_path("beside_styles").read_text())[shins]
    companions = entry["policy_kwargs"]["companions"]
    assert {part_of(companion).kind for companion in companions} == {"style"} and len(set(companions)) == 9
    entry |= {"n_envs": 6, "n_steps": 8, "window": 4, "gradient_steps": 1}
    entry["cost_to_go"] |= {"weight": 0.5, "updates": [2, 1]}
    entry["policy_kwargs"] |= {"companions": ["walk-penguin"], "precision": "fp32"}
    file, run = tmp_path / "small.yml", tmp_path / "run"
    file.write_text(yaml.safe_dump({shins: entry}))
    assert main(["train", shins, "--algo", "svg", "--conf-file", str(file), "--start", "walk-longshinswalk",
                 "--samples", "48", "--threads", "1", "--quiet", "--run-dir", str(run)]) == 0  # fmt: skip
    assert main(["train", "--resume", str(run), "--samples", "96", "--quiet"]) == 0
    assert "96 samples" in capsys.readouterr().out
    card = json.loads(export(run, tmp_path / "shins.safetensors").with_suffix(".json").read_text())
    assert card["training"]["svg"]["policy_kwargs"]["companions"] == ["walk-penguin"]
    assert card["training"]["svg"]["policy_kwargs"]["companion_kl"] is None


def test_companions_make_joined_worlds():

    worlds = make_worlds(RunSettings(ICE, samples=1, n_envs=10, threads=1), experiment(ICE, conf_file="stackable"))
    assert isinstance(worlds, JoinedWorlds) and [group.num_envs for group in worlds.groups] == [5] + 5 * [1]
    worlds.close()
