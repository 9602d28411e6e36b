"""What `adaptnet export` writes into a card."""

from dataclasses import replace

import pytest

from sb3_adaptnet import AdaptNetPolicy
from sb3_adaptnet.commands.export import card_of, means_of, public_path, task_of
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


def test_means_say_over_how_many_rollouts_they_are():
    rows = [{"samples": n, "goal_reward": 0.1 * n, "falls_per_minute": 2.0} for n in range(4)]
    assert means_of(rows) == {"rollouts": 4, "goal_reward": 0.15, "falls_per_minute": 2.0}
    assert means_of([*rows, {"samples": 5, "goal_reward": 0.4}]) == {"rollouts": 5, "goal_reward": 0.2}
    assert means_of([]) == {}


def test_classes_are_named_by_their_public_path():
    assert public_path(AdaptNetPolicy) == "sb3_adaptnet.AdaptNetPolicy"
    assert public_path(Backbone) == "sb3_adaptnet.modules.backbone.Backbone"
