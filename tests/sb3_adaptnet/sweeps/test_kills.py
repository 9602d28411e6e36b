"""Sweeps whose processes are killed: nothing is lost but the time since the last checkpoint."""

import sys

import pytest
from sweep_cases import (
    kill,
    rows_without_gaps,
    run_processes,
    saved,
    start_driver,
    sweep_file,
    wait_for,
    went_on_after,
)

from sb3_adaptnet.sweeps import read_status
from sb3_adaptnet.sweeps.dispatch import has_ray

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="processes are looked up as Linux lists them")


def _at_work(runs, run):
    """Process and parent of a run that has saved something and is still at it."""
    return saved(run) and run_processes(runs).get(run)


@pytest.mark.slow
@pytest.mark.parametrize(
    "mode",
    [
        "--plain",
        pytest.param(
            "", marks=pytest.mark.skipif(not has_ray(), reason="Ray is missing: pip install 'adaptnet-gym[sweep]'")
        ),
    ],
    ids=["plain", "ray"],
)
def test_two_by_two_runs_survive_the_kill_of_the_driver_and_of_a_worker(tmp_path, mode):
    runs, samples = tmp_path / "runs", 6400
    changes = {"usual": None, "bold": {"learning_rate": 1.0e-3}}
    file = sweep_file(tmp_path, samples, overrides=changes)
    words = [mode] if mode else []

    driver = start_driver(file, runs, *words)
    run = wait_for(lambda: next((run for run in run_processes(runs) if _at_work(runs, run)), None))
    kill(driver.pid)
    wait_for(lambda: not run_processes(runs))  # they notice, save and end
    kept = saved(run)
    print(f"{mode or 'ray'}: the driver was killed; {run.name} saved {kept} of {samples}")
    assert 0 < kept < samples and read_status(runs)[0].state != "failed"

    driver = start_driver(file, runs, *words)
    wait_for(lambda: run in run_processes(runs) and rows_without_gaps(run) * 64 > kept)
    process, parent = run_processes(runs)[run]
    kill(process if mode == "--plain" else parent)  # Ray's worker; the run's own process notices
    wait_for(lambda: run_processes(runs).get(run, (process,))[0] != process)
    print(f"a worker was killed; {run.name} goes on after {saved(run)}")
    said = driver.communicate(timeout=1800)[0]
    print(said)
    assert driver.returncode == 0, said

    rows = read_status(runs)
    assert [row.state for row in rows] == ["done"] * 4
    assert [rows_without_gaps(runs / row.run) for row in rows] == [100] * 4
    went_on = went_on_after(run)
    print(went_on)
    assert went_on[0] == kept and went_on[1] >= kept
    assert all((runs / row.run / "Toy.safetensors").is_file() for row in rows)
