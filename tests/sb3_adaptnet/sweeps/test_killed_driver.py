"""A sweep whose driver is killed: what is done stays done, what was begun goes on."""

import sys

import pytest
from sweep_cases import check_rows, driver, kill, run_processes, saved, sweep_file, wait_for, went_on_after
from toy_zoo import TOY, conf

from sb3_adaptnet.commands.main import main
from sb3_adaptnet.sweeps import prepare, read_status, read_sweep, units_of


def two_tasks(folder, first, second):
    """A sweep of two runs with so many samples."""
    task = {"id": TOY, "conf_file": conf(folder)}
    named = [{**task, "name": "first", "samples": first}, {**task, "name": "second", "samples": second}]
    return sweep_file(folder, tasks=named, seeds=[0])


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up as Linux lists them")
def test_a_sweep_goes_on_where_it_was_killed_and_skips_what_is_done(tmp_path, capfd):
    runs = tmp_path / "runs"
    first, second = runs / "first-seed0", runs / "second-seed0"
    file = two_tasks(tmp_path, first=128, second=10**9)
    prepare(units_of(read_sweep(file), 1), runs)
    assert main(["sweep", "run", str(first)]) == 0
    weights = (first / "first.safetensors").stat().st_mtime_ns

    with driver(file, runs, "--plain") as process:
        wait_for(lambda: saved(second) and run_processes(runs))
        assert main(["sweep", str(file), "--dir", str(runs), "--plain"]) == 2
        assert "another sweep is at work" in capfd.readouterr().err
        assert [row.state for row in read_status(runs)] == ["done", "running"]
        kill(process.pid)
        wait_for(lambda: not run_processes(runs))  # it noticed, saved and ended
    kept = saved(second)
    assert kept > 0 and [row.state for row in read_status(runs)] == ["done", "stopped"]

    file = two_tasks(tmp_path, first=128, second=kept + 64)
    again = ["sweep", str(file), "--dir", str(runs), "--plain"]
    assert main(again) == 0
    assert "2 runs in" in (said := capfd.readouterr().out) and "1 of them done" in said
    check_rows(second, kept + 64)
    assert went_on_after(second) == [kept]
    assert (second / "second.safetensors").is_file() and (second / "curve.png").is_file()
    assert main(again) == 0
    assert "2 of them done" in (said := capfd.readouterr().out) and "goes on" not in said
    assert (first / "first.safetensors").stat().st_mtime_ns == weights
