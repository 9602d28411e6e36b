"""What an evaluation leaves in a card."""

import json
import shutil

import pytest
from evaluation_cases import figures_with

from sb3_adaptnet.evaluation import evaluation_block, write_evaluation
from sb3_adaptnet.evaluation.card import eval_command
from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.shipped import pretrained_path
from sb3_adaptnet.weights.weight_file import read_weights

FIGURES = figures_with(goal_reward=0.8, failed_tests=("cadence none",), seconds=300.0, seed=4)


def test_the_block_holds_every_figure_once():
    block = evaluation_block(FIGURES, "adaptnet eval x")
    assert set(block) == {"command", "seed", "seconds", "figures"} and not {"seed", "seconds"} & set(block["figures"])
    assert {**block["figures"], "seed": block["seed"], "seconds": block["seconds"]} == FIGURES.as_dict()


@pytest.mark.parametrize("policy, options, command", [
    ("walk-stoop", {}, "adaptnet eval walk-stoop --seed 4 --seconds 300"),
    ("/far/away/my own.safetensors", {"base": "/there/b.safetensors", "motion": None, "env": "AdaptNet/Humanoid-X-v0"},
     "adaptnet eval 'my own.safetensors' --seed 4 --seconds 300 --base b.safetensors --env AdaptNet/Humanoid-X-v0"),
    ("a", {"base": "hf://me/walk2"}, "adaptnet eval a --seed 4 --seconds 300 --base hf://me/walk2"),
])  # fmt: skip
def test_the_command_names_no_folders(policy, options, command):
    assert eval_command(policy, FIGURES, **options) == command


@pytest.fixture
def shipped(tmp_path):
    """A copy of a shipped file with the card that such files had at first."""
    for suffix in (".safetensors", ".json"):
        file = shutil.copyfile(pretrained_path("walk").with_suffix(suffix), tmp_path / f"walk{suffix}")
    file = file.with_suffix(".safetensors")
    training = {name: value for name, value in read_weights(file)[1]["training"].items() if "means" not in name}
    amend_card(file, training=training, metrics={"goal_reward": 0.5}, evaluation=None)
    return file


def test_means_that_an_old_card_calls_metrics_get_their_name(shipped):
    before = read_weights(shipped)[1]
    assert write_evaluation(shipped, FIGURES, "adaptnet eval walk") == shipped
    after = read_weights(shipped)[1]
    assert "metrics" not in after and after["hash"] == before["hash"]
    assert after["training"] == {**before["training"], "means_of_last_rollouts": before["metrics"]}
    assert after["evaluation"]["figures"]["goal_reward"] == 0.8
    assert json.loads(shipped.with_suffix(".json").read_text()) == after


def test_metrics_of_a_users_own_stay(shipped):
    amend_card(shipped, training={"seed": 1}, metrics={"mine": 1.0})
    write_evaluation(shipped, FIGURES, "adaptnet eval walk")
    card = read_weights(shipped)[1]
    assert card["metrics"] == {"mine": 1.0} and card["training"] == {"seed": 1}
