"""Sweeps over the toy environment, small enough to be killed and taken up again within seconds."""

import csv
import os
import re
import signal
import time
from contextlib import contextmanager
from pathlib import Path

import yaml
from toy_zoo import ROOT, TOY, conf, run_command

from sb3_adaptnet.runs import RunFolder
from sb3_adaptnet.sweeps import UnitFolder

ROLLOUT = 64
"""Samples of a rollout of the toy's entry."""


def sweep_file(folder, samples=640, **changes):
    """A sweep over two seeds of the toy; `changes` are further keys."""
    task = {"id": TOY, "conf_file": conf(folder), "samples": samples}
    values = {"tasks": [task], "seeds": [0, 1], "minutes": 0.002, "resources": {"cpus": 1}, **changes}
    file = Path(folder) / "small.yml"
    file.write_text(yaml.safe_dump(values))
    return file


@contextmanager
def driver(file, runs, *more):
    """`adaptnet sweep` in a process of its own, which is gone afterwards."""
    words = ["sb3_adaptnet.commands.main", "sweep", str(file), "--dir", str(runs), *more]
    process = run_command(words, cwd=ROOT)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def saved(run):
    """Samples in a run's checkpoint; 0 while there is none."""
    return RunFolder.open(run).load()["samples"] if UnitFolder(run).begun else 0


def check_rows(run, last):
    """Fail unless a run's progress.csv has every rollout once, up to `last` samples, whatever was killed meanwhile."""
    with (Path(run) / "progress.csv").open() as stream:
        rows = [0, *(int(float(row["samples"])) for row in csv.DictReader(stream))]
    begun = {*rows, *went_on_after(run)}  # one that was stopped within a rollout goes on after its part
    assert all(after - ROLLOUT in begun for after in rows[1:]) and rows == sorted({*rows}), rows
    assert last <= rows[-1] < last + ROLLOUT


def went_on_after(run):
    """Samples that a run's processes went on after, in order."""
    return [int(number) for number in re.findall(r"goes on after (\d+) samples", UnitFolder(run).log.read_text())]


def wait_for(condition, seconds=600.0):
    """Wait until something holds, and return it."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "too slow"
        time.sleep(0.02)
    return found


def run_processes(runs):
    """Processes that are at work in runs below a folder: run's folder -> (its process, its parent's)."""
    found = {}
    for place in Path("/proc").glob("[0-9]*"):
        try:
            words = (place / "cmdline").read_bytes().decode().split("\0")
            parent = int((place / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:  # it is gone
            continue
        if words[3:5] == ["sweep", "run"] and Path(words[5]).parent == Path(runs):
            found[Path(words[5])] = (int(place.name), parent)
    return found


def kill(pid):
    """End a process as no handler can prevent."""
    os.kill(pid, signal.SIGKILL)
