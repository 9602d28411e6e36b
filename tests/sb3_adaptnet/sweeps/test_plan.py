"""From a sweep to its runs."""

import json
import re
import shutil
from pathlib import Path

import pytest
import yaml
from sweep_cases import sweep_file
from toy_zoo import TOY, conf

from adapt_envs import env_id
from adapt_envs.motion.library import STYLES, load_clip
from sb3_adaptnet.runs.experiment import experiment_of
from sb3_adaptnet.sweeps import UnitFolder, prepare, read_sweep, units_of
from sb3_adaptnet.weights.shipped import pretrained_names, pretrained_path

STOOP = "AdaptNet/Humanoid-Stoop-v0"


def units(folder, **values):
    file = folder / "mine.yml"
    file.write_text(yaml.safe_dump(values, sort_keys=False))
    return units_of(read_sweep(file), cores=4)


def test_runs_are_tasks_by_overrides_by_seeds(tmp_path):
    tasks = [STOOP, {"id": "AdaptNet/Humanoid-IceRun-v0", "seeds": [3], "samples": 500}]
    overrides = {"usual": None, "bold": {"learning_rate": 1.0e-3, "base": "walk"}}
    found = units(tmp_path, tasks=tasks, seeds=[0, 1], overrides=overrides)
    assert [unit.name for unit in found] == [
        "Stoop-usual-seed0", "Stoop-usual-seed1", "Stoop-bold-seed0", "Stoop-bold-seed1", "IceRun-usual-seed3",
        "IceRun-bold-seed3",
    ]  # fmt: skip
    assert [unit.entry["learning_rate"] for unit in found[1:3]] == [3.0e-5, 1.0e-3]
    assert [unit.settings.samples for unit in found[3:5]] == [1_600_000, 500]
    assert [unit.settings.base for unit in found[4:]] == ["run", "walk"]
    assert {unit.settings.threads for unit in found} == {4} and {unit.settings.device for unit in found} == {"cpu"}


def test_the_documented_sweep_can_be_run(tmp_path):
    page = (Path(__file__).parents[3] / "docs" / "sweeps.md").read_text()
    (example,) = re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)
    found = units(tmp_path, **yaml.safe_load(example))
    assert [unit.name for unit in found[3:6]] == ["Stoop-bold-seed1", "kick-usual-seed0", "kick-bold-seed0"]
    assert found[5].entry["learning_rate"] == 2.0e-4


def test_a_run_of_a_graphics_card_learns_there(tmp_path):
    (unit,) = units(tmp_path, tasks=[STOOP], resources={"gpus": 1, "cpus": 2.5})
    assert (unit.settings.device, unit.settings.threads) == ("cuda", 2)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"id": "AdaptNet/Humanoid-Moonwalk-v0"}, "mine.yml: Moonwalk: .*Moonwalk"),
        ({"id": "nosuch_module:A-v0"}, "No module named 'nosuch_module'"),
        ({"algo": "sac"}, "mine.yml: Stoop: there is no algorithm 'sac'; there are: ppo, svg"),
        ({"algo": 3}, "algo is 3, expected a name or a file"),
        ({"learning_rates": 1.0}, "unknown key 'learning_rates'; valid are: batch_size, callback"),
        ({"policy_kwargs": {"gamma": 1.0}}, "policy_kwargs: unknown key 'gamma'"),
        ({"algo": "svg", "episodes": {"steep": 1}}, "Episodes has no 'steep'; it has error_limit"),
        ({"callback": {"nosuch.Callback": {}}}, "no 'nosuch.Callback' to change; there are: sb3_adaptnet.Disc"),
        ({"samples": "many"}, "samples is 'many', expected a number of at least 1"),
        ({"n_envs": 0}, "n_envs is 0, expected a number of at least 1"),
        ({"base": "jog"}, "no pretrained weights named 'jog'"),
        ({"base": "jog.safetensors"}, "no base file 'jog.safetensors'"),
        ({"motion": "moonwalk"}, "moonwalk"),
        ({"world_model": "a.world.safetensors"}, "goes with algo svg, not with ppo"),
        ({"conf_file": "nosuch"}, "no experiment configuration named 'nosuch'"),
        ({"base": "walk-stoop"}, "holds 'adaptation', not 'base'"),
        ({"start": "walk"}, "holds 'base', not 'adaptation'"),
        ({"start": "run-longshins"}, "adapts base 'run'"),
        ({"env_kwargs": 5}, "env_kwargs is 5, expected a mapping"),
        ({"policy": "sb3_adaptnet.load_policy"}, "no class 'sb3_adaptnet.load_policy' .it is no BasePolicy"),
        ({"seeds": [2**32]}, "a seed in .* is 4294967296, expected at most 4294967295"),
    ],
)
def test_what_cannot_be_trained_gets_one_sentence(tmp_path, changes, sentence):
    with pytest.raises(ValueError, match=sentence):
        units(tmp_path, tasks=[{"id": STOOP, **changes}])


def test_svg_needs_a_world_model_beside_the_base(tmp_path):
    for kind in ("safetensors", "json"):
        shutil.copy(pretrained_path("run").with_suffix(f".{kind}"), tmp_path / f"jog.{kind}")
    task = {"id": STOOP, "base": str(tmp_path / "jog.safetensors")}
    assert len(units(tmp_path, tasks=[task])) == 1
    with pytest.raises(ValueError, match="no world model '.*jog.world.safetensors'"):
        units(tmp_path, tasks=[{**task, "algo": "svg"}])
    (unit,) = units(tmp_path, tasks=[{**task, "algo": "svg", "world_model": "new"}])
    assert unit.settings.world_model == "new"


def test_runs_have_names_of_their_own(tmp_path):
    with pytest.raises(ValueError, match="two runs are called 'Stoop-seed0'; give a task another `name`"):
        units(tmp_path, tasks=[STOOP, {"id": STOOP, "samples": 10}])


def test_what_is_not_of_the_suite_cannot_be_evaluated(tmp_path):
    with pytest.raises(ValueError, match="toy_env:Toy-v0 is not of this suite"):
        units(tmp_path, tasks=[{"id": TOY, "conf_file": conf(tmp_path)}], evaluate={"seconds": 9})


def test_files_are_named_so_that_any_working_directory_finds_them(tmp_path, monkeypatch):
    load_clip("Stoop").save(tmp_path / "mine.npz")
    monkeypatch.chdir(tmp_path)
    (unit,) = units(tmp_path, tasks=[{"id": "AdaptNet/Humanoid-Style-v0", "motion": "mine.npz"}])
    assert unit.settings.motion == str(tmp_path / "mine.npz")


def test_a_run_that_began_keeps_its_settings_but_not_its_samples(tmp_path):
    runs = tmp_path / "runs"
    before = units_of(read_sweep(sweep_file(tmp_path, 640)), 1)
    places = prepare(before, runs)
    assert [place.read() for place in places] == before
    other = units_of(read_sweep(sweep_file(tmp_path, 640, overrides={"usual": {"n_steps": 4}})), 1)
    assert [place.path.name for place in prepare(other, runs)] == ["Toy-usual-seed0", "Toy-usual-seed1"]
    for file in ("run.json", "checkpoint.pt"):  # as if it had begun
        (places[1].path / file).touch()
    prepare(units_of(read_sweep(sweep_file(tmp_path, 1280)), 1), runs)
    changed = sweep_file(tmp_path, 1280)
    conf(tmp_path, n_steps=4)
    with pytest.raises(ValueError, match="Toy-seed1 began with the entry's n_steps 8, the sweep says 4; remove"):
        prepare(units_of(read_sweep(changed), 1), runs)
    assert [UnitFolder(place.path).read().settings.samples for place in places] == [1280, 1280]


def of_card(values):
    return json.loads(json.dumps(values))


def said_of(arguments):
    """An algorithm's arguments as a card has them, without what the policy takes as None."""
    kwargs = {key: value for key, value in arguments["policy_kwargs"].items() if value is not None}
    return of_card({**arguments, "policy_kwargs": kwargs})


def test_pretrained_makes_what_ships_as_the_cards_say():
    found = {unit.task: unit for unit in units_of(read_sweep("pretrained"), 2)}
    cards = {name: json.loads(pretrained_path(name).with_suffix(".json").read_text()) for name in pretrained_names()}
    tasks = {unit.name: name for name, unit in found.items()}
    begun = {tasks[unit.after] for unit in found.values() if unit.after} - set(cards)  # starts that do not ship
    assert {name for name, card in cards.items() if card["kind"] == "adaptation"} == set(found) - begun
    for name, unit in ((name, unit) for name, unit in found.items() if name not in begun):
        card, settings = cards[name]["training"], unit.settings
        start = tasks.get(unit.after)
        entry = experiment_of(unit.entry, settings.env_id, settings.base, settings.algo, start=start)
        assert (settings.env_id, settings.seed) == (cards[name]["environment"], card["seed"])
        worlds = settings.n_envs or entry.n_envs
        assert 0 <= card["samples"] - settings.samples < worlds * entry.arguments["n_steps"]
        assert (unit.bits == 8) == (cards[name]["format"] == 2)
        assert said_of(entry.arguments) == said_of(card[settings.algo]) and worlds == card["worlds"]
        used = {cls.__name__: of_card(values) for cls, values in entry.callbacks}
        for key, said in (item for one in card["callbacks"] for item in one.items()):
            assert {option: used[key][option] for option in said} == said, name  # newer options are off there


def test_units_come_back_damaged_with_a_sentence(tmp_path):
    (place, _) = prepare(units_of(read_sweep(sweep_file(tmp_path)), 1), tmp_path)
    place.unit_file.write_text("settings: 3")
    with pytest.raises(ValueError, match="unit.yml is damaged"):
        place.read()
    with pytest.raises(ValueError, match="is not a run of a sweep: it has no unit.yml"):
        UnitFolder(Path(tmp_path / "none")).read()


def test_all_styles_learn_by_one_and_the_same_entry():
    found = units_of(read_sweep("styles"), 2)
    assert sorted(unit.settings.env_id for unit in found) == sorted(map(env_id, STYLES))
    assert all(unit.entry == found[0].entry and unit.settings.algo == "svg" for unit in found)
    assert found[0].settings.samples == 780_000
