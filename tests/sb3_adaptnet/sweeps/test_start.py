"""Runs that start from the weights of others of the same sweep."""

import json
from dataclasses import replace

import pytest
from sweep_cases import sweep_file
from toy_zoo import TOY, conf

from sb3_adaptnet.commands.main import main
from sb3_adaptnet.sweeps import prepare, read_sweep, units_of
from sb3_adaptnet.sweeps.plan import waves


def two_stages(folder, base, **changes):
    """A sweep of an adaptation and of one that starts from it; `changes` are of the latter."""
    task = {"id": TOY, "conf_file": conf(folder), "samples": 64}
    tasks = [{**task, "name": "a"}, {**task, "name": "b", "start": "a", **changes}]
    file = sweep_file(folder, tasks=tasks, seeds=[0])
    conf(folder, policy="sb3_adaptnet.AdaptNetPolicy", policy_kwargs={"base": str(base), "critic_lr": 6.0e-4})
    return file


def test_it_waits_for_the_run_that_it_starts_from_and_its_card_names_it(tmp_path, tiny_base, capsys):
    units = units_of(read_sweep(two_stages(tmp_path, tiny_base)), 1)
    first, second = prepare(units, tmp_path / "runs")
    assert main(["sweep", "run", str(second.path)]) == 2
    assert "it starts from a-seed0, which is not done" in capsys.readouterr().err and not second.begun
    assert main(["sweep", "run", str(first.path)]) == 0
    assert main(["sweep", "run", str(second.path)]) == 0 and second.is_done()
    card = json.loads((second.path / "b.json").read_text())
    assert card["training"]["ppo"]["policy_kwargs"]["start"] == "a"
    assert not second.is_stale()
    first.write(replace(first.read(), settings=replace(first.read().settings, samples=128)))
    assert main(["sweep", "run", str(first.path)]) == 0 and second.is_done() and second.is_stale()
    assert main(["sweep", "status", str(tmp_path / "runs")]) == 0
    assert "b-seed0: a-seed0 has other weights than it started from" in capsys.readouterr().out
    first.result.unlink()  # it is being done again
    assert not second.is_stale()
    assert main(["sweep", "status", str(tmp_path / "runs")]) == 0


def test_it_comes_in_a_wave_after_the_run_that_it_starts_from(tmp_path, tiny_base):
    units = units_of(read_sweep(two_stages(tmp_path, tiny_base, seeds=[3, 4])), 1)
    assert waves(units) == [["a-seed0"], ["b-seed3", "b-seed4"]]
    assert [unit.after for unit in units] == ["", "a-seed0", "a-seed0"]
    assert [place.read() for place in prepare(units, tmp_path / "runs")] == units


@pytest.mark.parametrize(
    ("start", "sentence"),
    [
        ("c", "no pretrained weights named 'c'"),
        ("c.safetensors", "it starts from 'c.safetensors', which is neither a task before it nor a file"),
    ],
)
def test_what_it_cannot_start_from_gets_one_sentence(tmp_path, tiny_base, start, sentence):
    with pytest.raises(ValueError, match=sentence):
        units_of(read_sweep(two_stages(tmp_path, tiny_base, start=start)), 1)


def test_it_starts_from_one_run(tmp_path, tiny_base):
    file = two_stages(tmp_path, tiny_base)
    file.write_text(file.read_text().replace("seeds:\n- 0", "seeds: [0, 1]"))
    with pytest.raises(ValueError, match="starts from 'a', of which there are 2 runs: a-seed0, a-seed1"):
        units_of(read_sweep(file), 1)
