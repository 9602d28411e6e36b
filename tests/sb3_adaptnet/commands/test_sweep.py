"""`adaptnet sweep`: its words, and a run of it that is measured on the real character."""

import json

import pytest
import yaml
from evaluation_cases import save_tiny_base
from filelock import FileLock
from toy_zoo import TOY, conf, python_path

from sb3_adaptnet.commands import sweep
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.runs.lock import lock_of
from sb3_adaptnet.sweeps import UnitFolder, prepare, read_sweep, units_of


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["nosuch.yml"], "no sweep named 'nosuch.yml'"),
        (["status", "nosuch"], "there is no sweep in nosuch"),
        (["run", "nosuch"], "nosuch is not a run of a sweep"),
        (["a", "b", "c"], "'a b c' is no sweep; write FILE.yml, or: status DIR"),
    ],
)
def test_bad_words_get_one_sentence(words, sentence, capsys):
    assert main(["sweep", *words]) == 2
    assert sentence in capsys.readouterr().err


def test_nothing_is_written_for_a_bad_file(tmp_path, capsys):
    file = tmp_path / "bad.yml"
    file.write_text("tasks: [AdaptNet/Humanoid-Stoop-v0, AdaptNet/Humanoid-Moonwalk-v0]")
    assert main(["sweep", str(file), "--dir", str(tmp_path / "runs")]) == 2
    assert "Moonwalk" in capsys.readouterr().err and not (tmp_path / "runs").exists()


def test_a_run_is_trained_exported_and_measured(tmp_path, capsys):
    task = {"id": "AdaptNet/Humanoid-Stoop-v0", "base": str(save_tiny_base(tmp_path)), "n_envs": 8, "samples": 128}
    file = tmp_path / "mine.yml"
    file.write_text(yaml.safe_dump({"tasks": [task], "evaluate": {"seconds": 1, "seeds": [4]}}))
    (place,) = prepare(units_of(read_sweep(file), 1), tmp_path / "runs")
    words = ["sweep", "run", str(place.path)]
    assert main(words) == 0 and place.is_done()
    card = json.loads((place.path / "Stoop.json").read_text())
    result = place.read_result()
    assert [one["seed"] for one in result["figures"]] == [4] and card["evaluation"]["seed"] == 4
    assert card["evaluation"]["command"].startswith("adaptnet eval Stoop.safetensors --seed 4")
    assert (place.path / "curve.png").read_bytes().startswith(b"\x89PNG")
    capsys.readouterr()
    assert main(["sweep", "status", str(tmp_path / "runs"), "--csv"]) == 0
    assert f",{result['figures'][0]['goal_reward']}," in capsys.readouterr().out
    assert main(words) == 0 and UnitFolder(place.path).read_result() == result


def test_what_may_go_well_later_is_no_bad_input(tmp_path, monkeypatch, capsys):
    task = {"id": "AdaptNet/Humanoid-Stoop-v0", "base": str(save_tiny_base(tmp_path)), "n_envs": 8, "samples": 128}
    file = tmp_path / "mine.yml"
    file.write_text(yaml.safe_dump({"tasks": [task]}))
    (place,) = prepare(units_of(read_sweep(file), 1), tmp_path / "runs")
    monkeypatch.setattr(sweep, "LOCK_SECONDS", 0.1)
    with FileLock(lock_of(place.path).lock_file):  # as another process does
        assert main(["sweep", "run", str(place.path)]) == sweep.TRY_AGAIN
    assert "another process is at work" in capsys.readouterr().err
    (place.path / "progress.csv").mkdir()  # the system refuses to write there, as a full disk would
    assert main(["sweep", "run", str(place.path)]) == sweep.TRY_AGAIN


def test_a_task_that_was_renamed_is_not_waited_for(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", python_path())
    task = {"id": TOY, "conf_file": conf(tmp_path), "samples": 64}
    file, folder = tmp_path / "mine.yml", tmp_path / "runs"
    file.write_text(yaml.safe_dump({"tasks": [{**task, "name": "before"}]}))
    prepare(units_of(read_sweep(file), 1), folder)
    file.write_text(yaml.safe_dump({"tasks": [{**task, "name": "after"}]}))
    assert main(["sweep", str(file), "--dir", str(folder), "--plain"]) == 0
    assert "1 runs: 1 done" in capsys.readouterr().out
