"""One lock for whoever works in a folder."""

import subprocess
import sys

import pytest

from sb3_adaptnet.runs.lock import held, is_locked, lock_of

HOLDER = """
import sys, time
from filelock import FileLock
lock = FileLock(sys.argv[1])
lock.acquire()
print("held", flush=True)
time.sleep(600)
"""
"""A process that holds a lock until it is killed."""


def test_a_lock_falls_with_whoever_held_it(tmp_path):
    assert not is_locked(tmp_path)
    words = [sys.executable, "-c", HOLDER, lock_of(tmp_path).lock_file]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        assert is_locked(tmp_path)
        process.kill()
        process.wait()
    assert not is_locked(tmp_path)


def test_who_holds_a_folder_may_train_in_it_and_it_stays_held(tmp_path):
    folder = tmp_path / "run"
    with held(folder):
        with held(folder):
            assert is_locked(folder)
        assert is_locked(folder)
    assert not is_locked(folder)


def test_a_folder_that_another_process_holds_is_refused_by_any_of_its_names(tmp_path, monkeypatch):
    words = [sys.executable, "-c", HOLDER, lock_of(tmp_path).lock_file]
    monkeypatch.chdir(tmp_path.parent)
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout.readline() == "held\n"
        for name in (tmp_path, tmp_path.relative_to(tmp_path.parent)):
            with pytest.raises(ValueError, match="another process is at work in"), held(name):
                pass
        process.kill()
        process.wait()
