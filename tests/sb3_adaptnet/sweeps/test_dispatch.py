"""Who runs what: the parts that need no cluster."""

import pytest
from sweep_cases import sweep_file

from sb3_adaptnet.runs import RunFolder
from sb3_adaptnet.sweeps import prepare, read_sweep, units_of
from sb3_adaptnet.sweeps.attendant import attend, last_line
from sb3_adaptnet.sweeps.dispatch import check_room, has_ray, ray_libraries
from sb3_adaptnet.sweeps.unit import FAILED


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


def test_the_last_words_of_a_log(tmp_path):
    log = tmp_path / "log.txt"
    log.write_bytes(b"one\n\xff two \n\n")
    assert last_line(log).endswith("two")
    log.write_text("\n")
    assert last_line(log) == "it said nothing"
