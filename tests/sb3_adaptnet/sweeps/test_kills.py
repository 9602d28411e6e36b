"""Sweeps whose driver and one of whose workers are killed: nothing is lost but the time since the last checkpoint."""

import sys

import pytest
from sweep_cases import check_rows, driver, kill, run_processes, saved, sweep_file, wait_for, went_on_after

from sb3_adaptnet.sweeps import read_status
from sb3_adaptnet.sweeps.dispatch import has_ray

SAMPLES = 12800
WITHOUT_RAY = pytest.mark.skipif(not has_ray(), reason="Ray is not installed: pip install 'adaptnet-gym[sweep]'")


def found_at_work(runs, more_than=0):
    """A run whose process has saved more than so many samples."""
    return next((run for run in run_processes(runs) if saved(run) > more_than), None)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up as Linux lists them")
@pytest.mark.parametrize("words", [["--plain"], pytest.param([], marks=WITHOUT_RAY)], ids=["plain", "ray"])
def test_two_by_two_runs_survive_the_kill_of_the_driver_and_of_a_worker(tmp_path, words):
    runs = tmp_path / "runs"
    file = sweep_file(tmp_path, SAMPLES, overrides={"usual": None, "bold": {"learning_rate": 1.0e-3}})
    with driver(file, runs, *words) as process:
        run = wait_for(lambda: found_at_work(runs))
        kill(process.pid)
        wait_for(lambda: not run_processes(runs))  # they notice, save and end
    kept = saved(run)
    print(f"\nthe driver was killed: {run.name} kept {kept} of {SAMPLES} samples")
    assert 0 < kept < SAMPLES

    with driver(file, runs, *words) as process:
        wait_for(lambda: run in run_processes(runs) and saved(run) > kept)
        worker, attendant = run_processes(runs)[run]
        kill(worker if words else attendant)  # the latter is Ray's worker; the run's own process notices
        wait_for(lambda: worker not in [pair[0] for pair in run_processes(runs).values()])
        print(f"a worker was killed: {run.name} kept {(again := saved(run))}")
        said = process.communicate(timeout=1800)[0]
    print(said)
    assert process.returncode == 0 and went_on_after(run) == [kept, again] and again > kept
    rows = read_status(runs)
    assert [row.state for row in rows] == ["done"] * 4
    for row in rows:
        check_rows(runs / row.run, SAMPLES)
        assert (runs / row.run / "Toy.safetensors").is_file()
