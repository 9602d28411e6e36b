"""Who runs what: the parts that need no cluster."""

import subprocess
import sys

import pytest
from sweep_cases import sweep_file

from sb3_adaptnet.runs import RunFolder
from sb3_adaptnet.sweeps import prepare, read_sweep, units_of
from sb3_adaptnet.sweeps.attendant import attend, last_line
from sb3_adaptnet.sweeps.dispatch import check_room, has_ray, ray_libraries
from sb3_adaptnet.sweeps.unit import FAILED, is_locked, lock_of


def test_more_than_the_machine_has_is_refused():
    check_room({"CPU": 2.0}, 2, 0)
    with pytest.raises(ValueError, match="a run takes 3 CPUs, this machine has 2"):
        check_room({"CPU": 2.0}, 3, 0)
    with pytest.raises(ValueError, match="a run takes 1 GPUs, this machine has 0"):
        check_room({"CPU": 2.0}, 1, 1)


@pytest.mark.skipif(has_ray(), reason="Ray is installed")
def test_without_ray_a_sentence_says_how_to_install_it():
    with pytest.raises(ValueError, match=r"pip install 'adaptnet-gym\[sweep\]'"):
        ray_libraries()


def test_a_run_that_was_refused_is_not_tried_again_and_says_why(tmp_path, capfd):
    place = prepare(units_of(read_sweep(sweep_file(tmp_path, 64)), 1), tmp_path)[0]
    RunFolder.new(place.write_config(place.read()), place.path).checkpoint.write_bytes(b"cut")
    assert not attend(place.path)
    assert "exit code 2: adaptnet sweep:" in place.failure.read_text() and "cut short" in capfd.readouterr().out
    assert place.state() == FAILED and not place.result.exists()


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


def test_the_last_words_of_a_log(tmp_path):
    log = tmp_path / "log.txt"
    log.write_bytes(b"one\n\xff two \n\n")
    assert last_line(log).endswith("two")
    log.write_text("\n")
    assert last_line(log) == "it said nothing"
