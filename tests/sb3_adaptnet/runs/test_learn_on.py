"""`learn_on`: any style goes on, from a file, by PPO."""

import json

import pytest
import yaml

from adapt_envs import env_id
from sb3_adaptnet.commands.export import export
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.weights.shipped import zoo_config_path


@pytest.mark.parametrize(
    ("name", "noise", "turns"),
    [("Stoop", 0.5, True), ("JauntySkip", 0.5, True), ("Obstacles", 0.5, False), ("PushWalk", 1.0, False),
     ("PushRun", 1.0, False), ("TerrainRugged", 1.0, False)],
)  # fmt: skip
def test_rollouts_are_long_and_noise_is_full_where_no_motion_shows_the_way(name, noise, turns):
    entry = experiment(env_id(name), conf_file="learn_on")
    assert entry.arguments["n_steps"] == 32 and entry.arguments["policy_kwargs"]["noise"] == noise
    (objectives,) = (values for cls, values in entry.callbacks if cls is DiscriminatorRewardCallback)
    assert ("in_turns" in objectives) == turns


def test_a_style_of_svg_goes_on(tmp_path):
    joyful = env_id("Joyful")
    entry = yaml.safe_load(zoo_config_path("learn_on").read_text())["default"]
    entry |= {"n_envs": 8, "n_steps": 4, "batch_size": 32, "n_epochs": 1}
    entry["callback"][0]["sb3_adaptnet.DiscriminatorRewardCallback"]["discriminator"]["batch_size"] = 16
    file, run = tmp_path / "small.yml", tmp_path / "run"
    file.write_text(yaml.safe_dump({joyful: entry}))
    assert main(["train", joyful, "--conf-file", str(file), "--start", "walk-sashay", "--samples", "64",
                 "--threads", "1", "--quiet", "--run-dir", str(run)]) == 0  # fmt: skip
    card = json.loads(export(run, tmp_path / "mine.safetensors").with_suffix(".json").read_text())
    assert card["environment"] == joyful and card["training"]["samples"] == 64
    assert card["training"]["ppo"]["policy_kwargs"]["start"] == "walk-sashay"
