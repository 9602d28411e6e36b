"""The command line: errors are one sentence, a closed pipe is none."""

import argparse
import subprocess
import sys

import pytest

from sb3_adaptnet.commands.main import COMMANDS, main, make_parser


@pytest.mark.parametrize("words, message", [
    (["train"], "name an environment"),
    (["train", "AdaptNet/Humanoid-Stoop-v0", "--world-model", "x.st"], "x.st goes with --algo svg, not with ppo"),
    (["train", "AdaptNet/Humanoid-Stop-v0"], "Did you mean: `Humanoid-Stoop`"),
    (["train", "CartPole-v1"], "CartPole-v1"),
    (["train", "nosuch_module:Toy-v0"], "No module named 'nosuch_module'"),
    (["train", "AdaptNet/Humanoid-Walk-v0", "--conf-file", "no/such.yml"], "no/such.yml"),
    (["train", "--resume", "no_such_run"], "no_such_run"),
    (["export", "no_such_run", "-o", "x"], "no_such_run"),
    (["export", "no_such_run", "-o", "no/such/folder/x"], "folder"),
    (["sweep", "pretrained", "--plain", "--address", "auto"], "leave out one of them"),
    (["sweep", "pretrained", "--csv"], "--csv does not go with 'pretrained'"),
    (["sweep", "status", "x", "--dir", "y"], "--dir does not go with 'status x'"),
])  # fmt: skip
def test_bad_input_gives_one_sentence(words, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1 and "Traceback" not in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("minutes", ["nan", "inf", "-1", "soon"])
def test_minutes_are_finite_and_not_negative(minutes, capsys):
    with pytest.raises(SystemExit) as end:
        main(["train", "AdaptNet/Humanoid-Stoop-v0", "--minutes", minutes])
    assert end.value.code == 2
    assert f"{minutes!r} is not a number of minutes, at least 0" in capsys.readouterr().err


@pytest.mark.parametrize("seed", ["-1", "4294967296", "one", "1.5"])
def test_seeds_are_numpys(seed, capsys):
    with pytest.raises(SystemExit) as end:
        main(["eval", "walk", "--seed", seed])
    assert end.value.code == 2
    assert f"{seed!r} is not a seed, a number from 0 to 4294967295" in capsys.readouterr().err


def test_a_style_is_named_once(capsys):
    with pytest.raises(SystemExit):
        main(["eval", "walk", "--styles", "walk-stoop=0.3,walk-stoop=0.7"])
    assert "'walk-stoop' stands there twice" in capsys.readouterr().err


def test_ctrl_c_is_no_traceback(monkeypatch, capsys):
    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("adapt_envs.commands.envs.run_list", stopped)
    assert main(["envs", "list"]) == 130
    assert capsys.readouterr().err == "adaptnet envs: stopped\n"


def test_a_reader_that_has_seen_enough_is_no_error():
    command = [sys.executable, "-m", "sb3_adaptnet.commands.main", "envs", "list"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.close()
    assert process.stderr.read() == "" and process.wait(timeout=60) == 141


def commands_of(parser):
    (subparsers,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    return subparsers.choices


def test_a_command_is_read_alone_and_is_the_same_as_among_all():
    everything = commands_of(make_parser())
    assert everything.keys() == COMMANDS.keys()
    for name, parser in everything.items():
        alone = commands_of(make_parser(name))
        assert name in alone and len(alone) <= 3
        assert alone[name].format_help() == parser.format_help()
