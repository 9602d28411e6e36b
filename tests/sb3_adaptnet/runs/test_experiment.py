"""Entries of the zoo's YAML files: what they hold, what they refuse."""

from dataclasses import replace

import pytest
import yaml
from toy_zoo import TOY, conf

from adapt_envs import SUITE, env_id
from sb3_adaptnet import FinetunePolicy, PretrainPolicy, callbacks, hyperparameters
from sb3_adaptnet.objectives.schedule import value_at
from sb3_adaptnet.runs.experiment import FIRST_STEP, experiment
from sb3_adaptnet.weights.shipped import zoo_config_path


@pytest.mark.parametrize("file", ["ppo", "paper"])
@pytest.mark.parametrize("name", SUITE)
def test_every_environment_has_an_entry(file, name):
    entry = experiment(env_id(name), conf_file=file)
    assert entry.n_envs == {"ppo": 256, "paper": 512}[file] and entry.samples >= 1_000_000
    assert entry.arguments["gamma"] == {"ppo": 0.98, "paper": 0.95}[file]
    assert entry.arguments["gae_lambda"] == 0.95 and entry.arguments["clip_range"] == 0.2
    (_, callback), *_ = entry.callbacks
    for samples in (0, entry.samples):
        weights = [value_at(weight, samples) for weight in callback["objective_weights"].values()]
        assert sum(weights) == pytest.approx(1.0)


def test_an_id_may_name_its_module():
    plain, named = (experiment(name) for name in (env_id("PushWalk"), f"adapt_envs:{env_id('PushWalk')}"))
    assert named.callbacks == plain.callbacks and len(named.callbacks) == 4
    assert experiment(f"adapt_envs:{env_id('Walk')}").policy is PretrainPolicy


def test_what_goes_on_from_an_adaptation_begins_gently():
    steps = experiment("AdaptNet/Humanoid-IceWalk-v0", start="walk-icewalk").arguments["policy_kwargs"]
    assert steps["start"] == "walk-icewalk" and steps["actor_lr"] == FIRST_STEP
    assert experiment("AdaptNet/Humanoid-Stoop-v0", algo="svg").arguments["regression_updates"] > 0
    assert experiment("AdaptNet/Humanoid-Stoop-v0", algo="svg", start="walk-stoop").arguments["regression_updates"] == 0


def test_schedules_are_refused(tmp_path):
    with pytest.raises(ValueError, match="learning_rate is 'lin_1e-4', a schedule; write a number"):
        experiment(TOY, conf_file=conf(tmp_path, learning_rate="lin_1e-4"))


def test_finetuning_differs_from_adapting_by_its_policy_alone():
    ours, theirs = (experiment(env_id("Style"), "walk", file) for file in ("ppo", "finetune"))
    assert theirs.policy is FinetunePolicy and ours.policy is not FinetunePolicy
    assert ours.arguments["policy_kwargs"]["critic"].pop("encoder") == "base"  # there is none when all of it learns
    assert replace(ours, policy=FinetunePolicy) == theirs


@pytest.mark.parametrize("name", ["Walk", "Run"])
def test_bases_can_be_continued_by_the_recipe_they_were_made_by(name):
    on, again = (experiment(env_id(name), conf_file=file) for file in ("continue", "large_rollouts"))
    assert on.policy is FinetunePolicy and "base" not in on.arguments["policy_kwargs"]  # the environment's default
    assert on.n_envs == again.n_envs
    assert {**on.arguments, "policy_kwargs": None} == {**again.arguments, "policy_kwargs": None}


def test_entries_for_ids_are_explicit_in_ppo_yml():
    """rl_zoo3 reads the same file and has no other fallback that would be ours."""
    entries = yaml.safe_load(zoo_config_path("ppo").read_text())
    assert {env_id(name) for name in SUITE} <= set(entries)


def test_the_papers_table():
    settings = hyperparameters("AdaptNet/Humanoid-Stoop-v0", conf_file="paper")
    policy = settings["policy_kwargs"]
    assert (policy["actor_lr"], policy["critic_lr"]) == (5e-6, 1e-4) and (policy["beta"], policy["kappa"]) == (
        0.01,
        0.01,
    )
    assert settings["n_steps"] * 512 == 4096 and settings["batch_size"] == 256 and settings["n_epochs"] == 5
    assert settings["vf_coef"] == 0.5  # this and the next line as released
    for name in ("Stoop", "Walk", "Run", "IceRun", "TerrainHills"):
        entry = experiment(f"AdaptNet/Humanoid-{name}-v0", conf_file="paper")
        assert [c.terminal_reward for c in entry.make_callbacks() if hasattr(c, "terminal_reward")] == [-1.0]


def test_hyperparameters_are_a_fresh_dict_with_the_base():
    first = hyperparameters("AdaptNet/Humanoid-Stoop-v0", base="run")
    assert first["policy_kwargs"]["base"] == "run"
    first["n_steps"] = 1
    assert hyperparameters("AdaptNet/Humanoid-Stoop-v0")["n_steps"] == 8


@pytest.mark.parametrize("changes, message", [
    ({"lerning_rate": 1e-4}, "'lerning_rate'.*learning_rate"),
    ({"policy_kwargs": {"hiden": 3}}, "policy_kwargs.*'hiden'.*hidden_sizes"),
    ({"callback": [{"sb3_adaptnet.DiscriminatorRewardCallback": {"kl": 1}}]}, "'kl'.*kl_range"),
    ({"policy": "sb3_adaptnet.NoSuchPolicy"}, "NoSuchPolicy"),
    ({"learning_rate": "5e-6"}, "learning_rate.*5e-06|learning_rate.*text"),
    ({"policy_kwargs": {"actor_lr": "5e-6"}}, "actor_lr is text to YAML"),
    ({"seed": 3}, "unknown key 'seed'"),
    ({"callback": {"sb3_adaptnet.DiscriminatorRewardCallback": {"discriminator": {"learning_rate": "5e-5"}}}},
     "learning_rate is text to YAML"),
    ({"callback": {"sb3_adaptnet.AttributeRamp": {}, "sb3_adaptnet.WeightAveraging": {}}}, "a dash of its own"),
])  # fmt: skip
def test_unknown_keys_are_refused(tmp_path, changes, message):
    with pytest.raises(ValueError, match=message):
        experiment(TOY, conf_file=conf(tmp_path, **changes))


def test_bad_files_are_refused(tmp_path):
    with pytest.raises(ValueError, match="no entry for 'Other-v0'.*Toy-v0"):
        experiment("Other-v0", conf_file=conf(tmp_path))
    broken = tmp_path / "broken.yml"
    broken.write_text("a: [1")
    with pytest.raises(ValueError, match="broken.yml is not a YAML file"):
        experiment(TOY, conf_file=broken)
    with pytest.raises(ValueError, match="nosuch"):
        experiment(TOY, conf_file="nosuch")


def test_callbacks_are_fresh_each_time():
    first, again = callbacks(env_id("PushWalk")), callbacks(env_id("PushWalk"))
    assert [type(callback).__name__ for callback in first] == [
        "DiscriminatorRewardCallback", "AttributeRamp", "WeightAveraging", "StyleCallback",
    ]  # fmt: skip
    assert all(a is not b for a, b in zip(first, again, strict=True))
    assert [type(one).__name__ for one in callbacks(env_id("Stoop"), algo="svg")] == ["StyleCallback"]
    assert (first[0].objectives, first[0].weights.at(0)) == (("imitation", "goal"), [0.2, 0.8])


def test_a_class_that_moved_is_named_where_it_is(tmp_path):
    """Run folders of version 0.1 name classes by the modules that they were in."""
    old = "sb3_adaptnet.callback.DiscriminatorRewardCallback"
    with pytest.raises(ValueError, match=f"no class '{old}'; write sb3_adaptnet.DiscriminatorRewardCallback$"):
        experiment(TOY, conf_file=conf(tmp_path, callback=old))
    with pytest.raises(ValueError, match="no class 'sb3_adaptnet.NoSuchPolicy' "):
        experiment(TOY, conf_file=conf(tmp_path, policy="sb3_adaptnet.NoSuchPolicy"))
