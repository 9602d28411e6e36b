"""All runs of a sweep at one glance."""

import csv
import io
from dataclasses import replace

import pytest
from evaluation_cases import figures_with
from sweep_cases import sweep_file

from sb3_adaptnet.runs.history import write_rows
from sb3_adaptnet.runs.lock import lock_of
from sb3_adaptnet.sweeps import prepare, read_status, read_sweep, units_of
from sb3_adaptnet.sweeps.status import csv_table, markdown_table, mean, text_table
from sb3_adaptnet.sweeps.sweep_file import Measurement
from sb3_adaptnet.sweeps.unit import Unit, UnitFolder


@pytest.fixture
def runs(tmp_path):
    """One run done and measured, one that failed half way, one that waits."""
    units = units_of(read_sweep(sweep_file(tmp_path, 640, seeds=[0, 1, 2])), 1)
    measured = Unit(**{**vars(units[0]), "measurement": Measurement(60.0, (3, 4))})
    first, second, _ = prepare([measured, *units[1:]], tmp_path / "runs")
    for place, count in ((first, 10), (second, 4)):
        rows = [{"samples": 64 * n, "goal_reward": 0.5, "falls_per_minute": n} for n in range(1, count + 1)]
        write_rows(place.path / "progress.csv", ("samples", "goal_reward", "falls_per_minute"), rows)
    figures = [figures_with(goal_reward=goal, falls_per_minute=1.0, visible=True, seconds=60.0) for goal in (0.6, 0.7)]
    first.write_result(measured, 640, first.path / "Toy.safetensors", [one.as_dict() for one in figures])
    second.failure.write_text("killed by signal 9\n")
    return tmp_path / "runs"


def test_a_row_says_how_far_a_run_is_and_how_good(runs):
    done, failed, waiting = read_status(runs)
    assert (done.run, done.seed, done.samples, done.wanted, done.state) == ("Toy-seed0", 0, 640, 640, "done")
    assert (done.goal_reward, done.falls_per_minute, done.visible, done.seconds) == (0.65, 1.0, True, 60.0)
    assert (done.training_goal, done.training_falls, done.tempo_error_m) == (0.5, 5.5, None)
    assert (failed.samples, failed.state, failed.problem) == (256, "failed", "killed by signal 9")
    assert failed.training_falls == 2.5 and failed.goal_reward is None
    assert (waiting.samples, waiting.state, waiting.training_goal) == (0, "waiting", None)


def test_a_run_that_a_process_holds_is_running(runs):
    with lock_of(runs / "Toy-seed2"):
        assert read_status(runs)[2].state == "running"


def test_other_measures_leave_it_undone(runs):
    (done, *_) = prepare(units_of(read_sweep(sweep_file(runs.parent, 704)), 1), runs)
    assert not done.is_done()


def test_other_bits_leave_it_undone(runs):
    place = UnitFolder(runs / "Toy-seed0")
    assert place.is_done()
    place.write(replace(place.read(), bits=8))
    assert place.read().bits == 8 and not place.is_done()


def test_the_tables_hold_the_same_runs(runs):
    rows = read_status(runs)
    read = list(csv.DictReader(io.StringIO(csv_table(rows))))
    assert [row["state"] for row in read] == ["done", "failed", "waiting"] and read[2]["training_goal"] == ""
    assert float(read[0]["goal_reward"]) == 0.65
    lines = markdown_table(rows).splitlines()
    assert len(lines) == 5 and len({line.count("|") for line in lines}) == 1
    assert "| Toy-seed0 | 640 | 640 | 0.500 | 5.50 | 0.650 | 1.00 | - | yes | done |" in lines
    text = text_table(rows)
    assert "3 runs: 1 done, 1 failed, 1 waiting" in text and "Toy-seed1: killed by signal 9" in text


def test_a_mean_needs_every_number():
    assert mean([{"a": 1.0}, {"a": 2.0}], "a") == 1.5
    assert mean([{"a": 1.0}, {}], "a") is None and mean([], "a") is None


@pytest.mark.parametrize("content", ['{"samples": "many"}', '{"samples": 1e9, "bits": 32}', "[1]", "{"])
def test_a_damaged_result_gets_one_sentence(runs, content):
    (runs / "Toy-seed0" / "result.json").write_text(content)
    with pytest.raises(ValueError, match="result.json is damaged"):
        read_status(runs)
