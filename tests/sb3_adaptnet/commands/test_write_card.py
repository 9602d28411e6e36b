"""`adaptnet eval --write-card`: what is printed is in the card, and the weights stay."""

import json

import pytest
from evaluation_cases import save_tiny_adaptation, save_tiny_base

from sb3_adaptnet.commands.main import main
from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.weight_file import read_weights

QUICK = ["--seconds", "2", "--threads", "1"]


@pytest.fixture
def tiny(tmp_path):
    return save_tiny_base(tmp_path)


def weight_bytes(file):
    content = file.read_bytes()
    return content[8 + int.from_bytes(content[:8], "little") :]


def test_the_card_has_what_is_printed(tiny, capsys):
    raw, before = weight_bytes(tiny), read_weights(tiny)[1]
    assert main(["eval", str(tiny), *QUICK, "--seed", "3", "--write-card", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    card = read_weights(tiny)[1]
    block = card.pop("evaluation")
    assert card == before and weight_bytes(tiny) == raw
    assert {**block["figures"], "seed": block["seed"], "seconds": block["seconds"]} == printed
    assert block["command"] == "adaptnet eval tiny.safetensors --seed 3 --seconds 2"
    assert json.loads(tiny.with_suffix(".json").read_text())["evaluation"] == block


def test_a_second_evaluation_replaces_the_first_and_says_so(tiny, capsys):
    amend_card(tiny, evaluation={"seed": 1})
    assert main(["eval", str(tiny), *QUICK, "--seed", "2", "--write-card"]) == 0
    assert f"wrote {tiny}" in capsys.readouterr().out
    assert read_weights(tiny)[1]["evaluation"]["seed"] == 2


@pytest.mark.parametrize(
    "words", [["--alpha", "0.5"], ["--styles", "other"], ["--push-scale", "0.5"], ["--speed", "1"]]
)
def test_the_card_is_about_the_file_as_it_is(tiny, capsys, words):
    adapted = save_tiny_adaptation(tiny, "one")
    content = adapted.read_bytes()
    assert main(["eval", str(adapted), *QUICK, "--write-card", *words]) == 2
    assert "--write-card measures the file as it is" in capsys.readouterr().err
    assert adapted.read_bytes() == content
