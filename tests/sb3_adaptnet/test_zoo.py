"""Experiments of the zoo: YAML entries, run folders, resuming, kills, export, rl_zoo3."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
import torch
import yaml
from stable_baselines3.common.callbacks import BaseCallback

from adapt_envs import SUITE, env_id
from adapt_envs.motion.library import load_clip
from sb3_adaptnet import FinetunePolicy, PretrainPolicy, callbacks, hyperparameters, load_policy
from sb3_adaptnet.hyperparameters import experiment
from sb3_adaptnet.points import value_at
from sb3_adaptnet.resources import zoo_config_path
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.zoo.command import main
from sb3_adaptnet.zoo.export import export
from sb3_adaptnet.zoo.random_state import random_states, restore_random_states
from sb3_adaptnet.zoo.run_folder import RunFolder, RunSettings
from sb3_adaptnet.zoo.saver import restore, snapshot
from sb3_adaptnet.zoo.training import build_learner, learn, resume, start

ROOT = Path(__file__).resolve().parents[2]
TOY = "toy_env:Toy-v0"
ENTRY = {
    "n_envs": 8,
    "n_timesteps": 640,
    "policy": "sb3_adaptnet.PretrainPolicy",
    "n_steps": 8,
    "batch_size": 32,
    "n_epochs": 1,
    "learning_rate": 3.0e-4,
    "normalize_advantage": False,
    "policy_kwargs": {"gru_size": 8, "hidden_sizes": [16, 8], "critic_lr": 6.0e-4},
    "callback": [
        {
            "sb3_adaptnet.callback.DiscriminatorRewardCallback": {
                "objective_weights": {"imitation": 0.4, "goal": 0.6},
                "discriminator": {"batch_size": 32, "network": {"gru": 8, "hidden": [8], "heads": 4}},
            }
        }
    ],
}


def conf(folder, **changes):
    file = Path(folder) / "toy.yml"
    file.write_text(yaml.safe_dump({TOY: {**ENTRY, **changes}, "Toy-v0": {**ENTRY, **changes}}))
    return str(file)


def settings(folder, **changes):
    return RunSettings(TOY, **{"samples": 640, "seed": 1, "conf_file": conf(folder), "threads": 1, **changes})


# ---- YAML -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("file", ["ppo", "paper"])
@pytest.mark.parametrize("name", SUITE)
def test_every_environment_has_an_entry(file, name):
    assert file == "paper" or env_id(name) in yaml.safe_load(zoo_config_path(file).read_text())  # not by its `default`
    entry = experiment(env_id(name), conf_file=file)
    assert entry.n_envs == 512 and entry.samples >= 1_000_000
    assert entry.ppo["gamma"] == {"ppo": 0.98, "paper": 0.95}[file]
    assert entry.ppo["gae_lambda"] == 0.95 and entry.ppo["clip_range"] == 0.2
    (_, callback), *_ = entry.callbacks
    for samples in (0, entry.samples):
        weights = [value_at(weight, samples) for weight in callback["objective_weights"].values()]
        assert sum(weights) == pytest.approx(1.0)


def test_an_id_may_name_its_module():
    plain, named = (experiment(name) for name in (env_id("PushWalk"), f"adapt_envs:{env_id('PushWalk')}"))
    assert named.callbacks == plain.callbacks and len(named.callbacks) == 2
    assert experiment(f"adapt_envs:{env_id('Walk')}").policy is PretrainPolicy


def test_schedules_are_refused(tmp_path):
    with pytest.raises(ValueError, match="learning_rate is 'lin_1e-4', a schedule; write a number"):
        experiment(TOY, conf_file=conf(tmp_path, learning_rate="lin_1e-4"))


def test_finetuning_differs_from_adapting_by_its_policy_alone():
    ours, theirs = (experiment(env_id("Stoop"), "walk", file) for file in ("ppo", "finetune"))
    assert theirs.policy is FinetunePolicy and ours.policy is not FinetunePolicy
    assert replace(ours, policy=FinetunePolicy) == theirs


@pytest.mark.parametrize("name", ["Walk", "Run"])
def test_bases_can_be_continued_by_the_recipe_they_were_made_by(name):
    on, anew = (experiment(env_id(name), conf_file=file) for file in ("continue", "ppo"))
    assert on.policy is FinetunePolicy and "base" not in on.ppo["policy_kwargs"]  # the environment's default
    assert on.n_envs == anew.n_envs
    assert {**on.ppo, "policy_kwargs": None} == {**anew.ppo, "policy_kwargs": None}


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


def test_hyperparameters_are_a_fresh_dict_with_the_base():
    first = hyperparameters("AdaptNet/Humanoid-Stoop-v0", base="run")
    assert first["policy_kwargs"]["base"] == "run"
    first["n_steps"] = 1
    assert hyperparameters("AdaptNet/Humanoid-Stoop-v0")["n_steps"] == 16


@pytest.mark.parametrize("changes, message", [
    ({"lerning_rate": 1e-4}, "'lerning_rate'.*learning_rate"),
    ({"policy_kwargs": {"hiden": 3}}, "policy_kwargs.*'hiden'.*hidden_sizes"),
    ({"callback": [{"sb3_adaptnet.callback.DiscriminatorRewardCallback": {"kl": 1}}]}, "'kl'.*kl_range"),
    ({"policy": "sb3_adaptnet.NoSuchPolicy"}, "NoSuchPolicy"),
    ({"learning_rate": "5e-6"}, "learning_rate.*5e-06|learning_rate.*text"),
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


# ---- runs -----------------------------------------------------------------------------------------------------------


def equal(a, b):
    if isinstance(a, torch.Tensor):
        return torch.equal(a, b)
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(equal(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(equal, a, b))
    return a == b


def test_a_checkpoint_restores_everything_exactly(tmp_path):
    folder = start(settings(tmp_path), tmp_path / "run", quiet=True)
    state = folder.load()
    learner = build_learner(folder.settings, samples_done=640)
    learner.discriminators.init_callback(learner.model)
    restore(learner.model, learner.discriminators, state)
    again = snapshot(learner.model, learner.discriminators, state["seconds"])
    assert again.keys() == state.keys()
    for key in state:
        assert equal(again[key], state[key]), key
    assert state["samples"] == 640 and state["optimizer"]["state"]  # something was there to restore


def test_a_run_keeps_the_settings_it_began_with(tmp_path):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    conf(tmp_path, n_steps=4, batch_size=16)  # the file changes afterwards
    assert (
        folder.experiment.ppo["n_steps"] == 8
        and experiment(TOY, conf_file=conf(tmp_path, n_steps=4)).ppo["n_steps"] == 4
    )
    Path(folder.settings.conf_file).unlink()
    resume(folder.path, 128, quiet=True)
    assert folder.load()["samples"] == 128
    card = json.loads(export(folder.path, tmp_path / "mine").with_suffix(".json").read_text())
    assert card["training"]["ppo"]["n_steps"] == 8
    folder.config.unlink()
    with pytest.raises(ValueError, match=r"no such configuration file: .*config\.yml"):
        resume(folder.path, 192, quiet=True)


def test_a_run_without_its_base_leaves_nothing(tmp_path, capsys):
    finetuning = conf(tmp_path, policy="sb3_adaptnet.FinetunePolicy", policy_kwargs={"critic_lr": 6.0e-4})
    words = ["train", TOY, "--conf-file", finetuning, "--base", "nosuch.safetensors"]
    with pytest.warns(UserWarning, match="no base file"):
        assert main([*words, "--run-dir", str(tmp_path / "run")]) == 2
    assert "no base file 'nosuch.safetensors'" in capsys.readouterr().err and not (tmp_path / "run").exists()


def test_a_run_can_be_resumed_from_its_first_moment(tmp_path):
    class Killed(Exception):
        pass

    class Killer(BaseCallback):
        def _on_step(self):
            raise Killed

    learner = build_learner(settings(tmp_path))
    learner.others.append(Killer())
    with pytest.raises(Killed):
        learn(learner, folder := RunFolder.new(settings(tmp_path), tmp_path / "run"), quiet=True)
    assert folder.load()["samples"] == 0
    assert resume(folder.path, 64, threads=1, device="cpu", quiet=True).load()["samples"] == 64


def test_a_run_keeps_its_clip_when_it_moves(tmp_path):
    clip = load_clip("Stoop")
    clip.save(tmp_path / "mine.npz")
    asked = RunSettings(env_id("Style"), samples=64, motion=str(tmp_path / "mine.npz"))
    RunFolder.new(asked, tmp_path / "here")
    (tmp_path / "mine.npz").unlink()
    moved = (tmp_path / "here").rename(tmp_path / "there")
    folder = RunFolder.open(moved)
    assert folder.settings.motion == str(moved / "motion.npz")
    assert load_clip(folder.settings.motion).digest == clip.digest
    folder.write_settings(folder.settings)
    assert json.loads((moved / "run.json").read_text())["motion"] == "motion.npz"


def test_callbacks_are_made_anew_each_time():
    first, again = callbacks(env_id("PushWalk")), callbacks(env_id("PushWalk"))
    assert [type(callback).__name__ for callback in first] == ["DiscriminatorRewardCallback", "AttributeRamp"]
    assert all(a is not b for a, b in zip(first, again, strict=True))
    assert first[0].weights == {"imitation": 0.25, "goal": 0.75}


def test_a_stopped_run_goes_on(tmp_path):
    folder = start(settings(tmp_path, samples=320), tmp_path / "run", quiet=True)
    rows = list(csv.DictReader(folder.progress.open()))
    assert [int(row["samples"]) for row in rows] == [64 * n for n in range(1, 6)]
    assert main(["train", "--resume", str(folder.path), "--samples", "640", "--quiet"]) == 0
    rows = list(csv.DictReader(folder.progress.open()))
    assert [int(row["samples"]) for row in rows] == [64 * n for n in range(1, 11)]
    seconds = [float(row["seconds"]) for row in rows]
    assert seconds == sorted(seconds) and RunFolder.open(folder.path).settings.samples == 640
    assert folder.curve.read_bytes().startswith(b"\x89PNG")
    assert list(folder.path.glob("events.out.tfevents*"))


def run_command(arguments, **kwargs):
    env = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}"}
    command = [sys.executable, "-m", *arguments]
    return subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **kwargs)


def train_command(tmp_path, *more):
    words = [
        "sb3_adaptnet.zoo.command",
        "train",
        TOY,
        "--conf-file",
        conf(tmp_path),
        "--run-dir",
        str(tmp_path / "run"),
    ]
    return run_command([*words, "--samples", "1e9", "--minutes", "0.002", "--threads", "1", *more])


def wait_for(condition, process, seconds=120):
    end = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None and time.monotonic() < end, (
            process.stdout.read() if process.poll() else "too slow"
        )
        time.sleep(0.02)


def test_goes_on_after_kill_9_and_saves_at_ctrl_c(tmp_path):
    folder = RunFolder(tmp_path / "run", settings(tmp_path))
    process = train_command(tmp_path)
    wait_for(lambda: folder.checkpoint.exists() and folder.load()["samples"] > 0, process)
    time.sleep(0.3)
    process.kill()
    process.wait()
    saved = folder.load()["samples"]
    reached = csv_samples(folder)  # rows written after the last checkpoint are past `saved` already
    assert saved > 0 and saved % 64 == 0
    process = run_command(["sb3_adaptnet.zoo.command", "train", "--resume", str(folder.path), "--minutes", "99"])
    wait_for(lambda: csv_samples(folder) > max(saved, reached), process)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[0]
    assert process.returncode == 130 and "--resume" in said
    assert folder.load()["samples"] > saved
    assert not list(folder.path.glob("*.tmp"))


def csv_samples(folder):
    rows = list(csv.DictReader(folder.progress.open())) if folder.progress.exists() else []
    return max((int(float(row["samples"])) for row in rows if row["samples"]), default=0)


def test_random_states_restore(tmp_path):
    torch.save(random_states(), tmp_path / "states")
    first = torch.rand(3)
    restore_random_states(torch.load(tmp_path / "states", weights_only=True))
    assert torch.equal(first, torch.rand(3))


def test_export_writes_a_base_that_acts(tmp_path):
    folder = start(settings(tmp_path), tmp_path / "run", quiet=True)
    file = export(folder.path, tmp_path / "mine.safetensors")
    card = json.loads(file.with_suffix(".json").read_text())
    assert card["training"]["samples"] == 640 and card["environment"] == TOY and "goal_reward" in card["metrics"]
    env = AdaptVecEnv(TOY, num_envs=2)
    trained = build_learner(folder.settings).model.policy
    trained.load_state_dict(folder.load()["policy"])
    trained.set_training_mode(False)
    observations = env.reset()
    ours, _ = load_policy(file, env).predict(observations, deterministic=True)
    theirs, _ = trained.predict(observations, deterministic=True)
    assert (ours == theirs).all()


def test_a_base_that_went_on_is_a_base_again(tmp_path):
    """What `continue.yml` does: the card names the base it came from, not where its file lay."""
    first = export(
        start(settings(tmp_path, samples=64), tmp_path / "first", quiet=True).path, tmp_path / "toy.safetensors"
    )
    finetuning = {"policy": "sb3_adaptnet.FinetunePolicy", "policy_kwargs": {"critic_lr": 6.0e-4}}
    on = RunSettings(TOY, samples=64, conf_file=conf(tmp_path, **finetuning), base=str(first), threads=1)
    card = json.loads(
        export(start(on, tmp_path / "on", quiet=True).path, tmp_path / "on.st").with_suffix(".json").read_text()
    )
    assert card["kind"] == "base" and card["training"]["ppo"]["policy_kwargs"]["base"] == "toy"
    assert str(tmp_path) not in json.dumps(card)


@pytest.mark.parametrize("words, message", [
    (["train"], "name an environment"),
    (["train", "AdaptNet/Humanoid-Stop-v0"], "Did you mean: `Humanoid-Stoop`"),
    (["train", "CartPole-v1"], "CartPole-v1"),
    (["train", "nosuch_module:Toy-v0"], "No module named 'nosuch_module'"),
    (["train", "AdaptNet/Humanoid-Walk-v0", "--conf-file", "no/such.yml"], "no/such.yml"),
    (["train", "--resume", "no_such_run"], "no_such_run"),
    (["export", "no_such_run", "-o", "x"], "no_such_run"),
    (["export", "no_such_run", "-o", "no/such/folder/x"], "folder"),
])  # fmt: skip
def test_bad_input_gives_one_sentence(words, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1 and "Traceback" not in said
    assert list(tmp_path.iterdir()) == []


def test_a_reader_that_has_seen_enough_is_no_error():
    command = [sys.executable, "-m", "sb3_adaptnet.zoo.command", "envs", "list"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.close()
    assert process.stderr.read() == "" and process.wait(timeout=60) == 141


def test_a_resumed_run_refuses_changes_and_damage(tmp_path, capsys):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    assert main(["train", "--resume", str(folder.path), "--seed", "3"]) == 2
    assert main(["train", "Other-v0", "--resume", str(folder.path)]) == 2
    assert main(["train", TOY, "--conf-file", conf(tmp_path), "--run-dir", str(folder.path)]) == 2
    folder.checkpoint.write_bytes(folder.checkpoint.read_bytes()[:500])
    assert main(["train", "--resume", str(folder.path)]) == 2
    said = capsys.readouterr().err.splitlines()
    assert ["--seed" in said[0], "Other-v0" in said[1], "holds a run" in said[2], "cut short" in said[3]] == [True] * 4


def test_bench_train_accounts_for_the_whole_iteration(tmp_path, capsys):
    words = [
        "bench",
        "train",
        "--id",
        TOY,
        "--worlds",
        "8",
        "--iterations",
        "1",
        "--conf-file",
        conf(tmp_path),
        "--json",
    ]
    assert main(words) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["speedup_over_plain"] == pytest.approx(
        figures["samples_per_second"] / figures["plain_samples_per_second"]
    )
    assert all(figures["seconds"][part] > 0 for part in ("act", "simulate", "discriminators", "update", "other"))
    assert sum(figures["seconds"].values()) == pytest.approx(64 / figures["samples_per_second"])


# ---- rl_zoo3 --------------------------------------------------------------------------------------------------------


def test_rl_zoo3_trains_natively_and_enjoys(tmp_path):
    common = ["--algo", "ppo", "--env", "Toy-v0", "--gym-packages", "toy_env", "sb3_adaptnet.zoo", "-f", str(tmp_path)]
    train = run_command(["rl_zoo3.train", *common, "--conf-file", conf(tmp_path), "--eval-freq", "-1", "--seed", "0"])
    said = train.communicate(timeout=300)[0]
    assert train.returncode == 0, said
    assert "imitation_reward" in said and "Using 8 environments" in said
    assert (tmp_path / "ppo" / "Toy-v0_1" / "Toy-v0.zip").is_file()
    enjoy = run_command(["rl_zoo3.enjoy", *common, "--no-render", "-n", "50", "--num-threads", "1"])
    said = enjoy.communicate(timeout=300)[0]
    assert enjoy.returncode == 0 and "Episode Reward" in said, said
