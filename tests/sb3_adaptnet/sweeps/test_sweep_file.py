"""Sweeps as YAML files: what they say, and one sentence where they do not."""

import pytest

from sb3_adaptnet.sweeps import read_sweep
from sb3_adaptnet.sweeps.sweep_file import Measurement, Resources, short_name

STOOP = "AdaptNet/Humanoid-Stoop-v0"
FULL = f"""
.quick: &quick {{samples: 2.0e+6}}
tasks:
  - {STOOP}
  - {{id: AdaptNet/Humanoid-Limp-v0, name: limp, seeds: [5], bits: 8, <<: *quick}}
seeds: [0, 1]
bits: 16
overrides:
  usual:
  bold: {{learning_rate: 1.0e-3}}
evaluate: {{seconds: 60, seeds: [7, 8]}}
resources: {{cpus: 2, gpus: 0.5, threads: 3}}
minutes: 1
retries: 0
"""


def write(folder, text, name="mine.yml"):
    file = folder / name
    file.write_text(text)
    return file


def test_a_file_says_tasks_seeds_overrides_and_resources(tmp_path):
    sweep = read_sweep(write(tmp_path, FULL))
    stoop, limp = sweep.tasks
    assert (stoop.name, stoop.seeds, stoop.bits, stoop.changes) == ("Stoop", (0, 1), 16, {})
    assert (limp.name, limp.seeds, limp.bits, limp.changes) == ("limp", (5,), 8, {"samples": 2.0e6})
    assert sweep.overrides == {"usual": {}, "bold": {"learning_rate": 1.0e-3}}
    assert sweep.measurement == Measurement(60, (7, 8)) and sweep.resources == Resources(2, 0.5, 3)
    assert (sweep.name, sweep.minutes, sweep.retries) == ("mine", 1, 0)


def test_little_is_enough(tmp_path):
    sweep = read_sweep(write(tmp_path, f"tasks: [{STOOP}]"))
    assert sweep.tasks[0].seeds == (0,) and sweep.tasks[0].bits == 32 and sweep.overrides == {"": {}}
    assert sweep.measurement is None and sweep.resources == Resources()


@pytest.mark.parametrize("name", ["run", "Run", "result"])
def test_no_card_lies_on_a_runs_own_files(tmp_path, name):
    (task,) = read_sweep(write(tmp_path, "tasks: [AdaptNet/Humanoid-Run-v0]")).tasks
    assert task.name == "HumanoidRun"
    text = f"tasks: [{{id: {STOOP}, name: {name}}}]"
    with pytest.raises(ValueError, match=f"is '{name}', as a file of every run's folder is called"):
        read_sweep(write(tmp_path, text))


def test_short_names():
    ids = ("AdaptNet/Humanoid-IceRun-v0", "my_module:My-Hill-v12", "Walker2d-v5")
    assert [*map(short_name, ids)] == ["IceRun", "My-Hill", "Walker2d"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("- a", "the file is .'a'., expected a mapping"),
        ("tasks: [", "not a YAML file"),
        ("seeds: [1]", "tasks is None, expected a list of environment ids"),
        ("tasks: []", "tasks is .., expected a list"),
        (f"tasks: [{STOOP}]\nseed: 3", "unknown key 'seed'; valid are: tasks, seeds, bits"),
        ("tasks: [{name: a}]", "the task {'name': 'a'} names no environment"),
        (f"tasks: [{STOOP}]\nseeds: 3", "seeds is 3, expected a list of whole numbers"),
        (f"tasks: [{STOOP}]\nseeds: [a]", "a seed in .* is 'a', expected a number"),
        (f"tasks: [{STOOP}]\nseeds: [-1]", "is -1, expected a number of at least 0"),
        (f"tasks: [{STOOP}]\nseeds: [0.5]", "is 0.5, expected a whole number"),
        (f"tasks: [{STOOP}]\nseeds: [true]", "is True, expected a number"),
        (f"tasks: [{STOOP}]\nseeds: [2, 2]", "a seed stands there twice"),
        (f"tasks: [{{id: {STOOP}, name: a/b}}]", "is 'a/b', expected a word of letters"),
        (f"tasks: [{STOOP}]\noverrides: [a]", "overrides is .'a'., expected a mapping"),
        (f"tasks: [{STOOP}]\noverrides: {{a: 3}}", "a is 3, expected a mapping"),
        (f"tasks: [{STOOP}]\nevaluate: {{seconds: 1e3}}", "is text to YAML: write 1000.0 instead of 1e3"),
        (f"tasks: [{STOOP}]\nevaluate: {{}}", "seconds is None, expected a number of at least 1"),
        (f"tasks: [{STOOP}]\nresources: {{cpu: 1}}", "unknown key 'cpu'; valid are: cpus, gpus, threads"),
        (f"tasks: [{STOOP}]\nresources: {{threads: 0}}", "threads is 0, expected a number of at least 1"),
        (f"tasks: [{STOOP}]\nbits: 4", "bits of AdaptNet/Humanoid-Stoop-v0 is 4, expected one of 32, 16, 8"),
        (f"tasks: [{STOOP}]\nretries: many", "retries is 'many', expected a number"),
    ],
)
def test_what_is_wrong_gets_one_sentence(tmp_path, text, sentence):
    with pytest.raises(ValueError, match=sentence):
        read_sweep(write(tmp_path, text))


def test_a_file_that_is_not_there_names_those_that_ship():
    with pytest.raises(ValueError, match="no sweep named 'nosuch.yml'; there are .*'pretrained'"):
        read_sweep("nosuch.yml")
