"""Training runs: folders, checkpoints, resuming, kills, export."""

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch
from stable_baselines3.common.callbacks import BaseCallback
from torch.nn.utils import parameters_to_vector
from toy_zoo import TOY, conf, run_command, settings

from adapt_envs import env_id
from adapt_envs.motion.library import load_clip
from sb3_adaptnet import WeightAveraging, load_policy
from sb3_adaptnet.commands.export import export
from sb3_adaptnet.commands.main import main
from sb3_adaptnet.runs.experiment import experiment
from sb3_adaptnet.runs.history import read_rows
from sb3_adaptnet.runs.run_folder import RunFolder, RunSettings
from sb3_adaptnet.runs.saver import RunSaver, random_states, restore, restore_random_states, snapshot
from sb3_adaptnet.runs.training import build_learner, resume, start, stopping
from sb3_adaptnet.vec_env import AdaptVecEnv


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


def test_a_ramp_by_falls_and_a_range_by_samples_go_on_where_they_were(tmp_path):
    ramp = {"attribute": "drift", "first": 0.1, "last": 0.2, "samples": 1280, "falls_per_minute": 1e6}
    discriminators = {"sb3_adaptnet.DiscriminatorRewardCallback": {"kl_range": [{0: 0.02, 1280: 0.01}, 0.03]}}
    asked = settings(tmp_path)
    conf(tmp_path, callback=[discriminators, {"sb3_adaptnet.AttributeRamp": ramp}])
    folder = start(asked, tmp_path / "run", quiet=True)
    resume(folder.path, 1280, quiet=True)
    assert folder.experiment.callbacks[0][1]["kl_range"][0] == {0: 0.02, 1280: 0.01}
    drift = [float(row["drift"]) for row in read_rows(folder.progress)]
    assert len(drift) == 20 and drift == pytest.approx([0.1 + 0.005 * i for i in range(20)], abs=1e-4)


def averaging_run(tmp_path):
    """A finished run with averaged weights, and a learner that is ready to be restored from it, with its average."""
    asked = settings(tmp_path)
    discriminators = {"sb3_adaptnet.DiscriminatorRewardCallback": {}}
    conf(tmp_path, callback=[discriminators, {"sb3_adaptnet.WeightAveraging": {"decay": 0.9}}])
    folder = start(asked, tmp_path / "run", quiet=True)
    learner = build_learner(folder.settings, samples_done=640)
    averaging = next(callback for callback in learner.others if isinstance(callback, WeightAveraging))
    for callback in (learner.discriminators, averaging):
        callback.init_callback(learner.model)
    return folder, learner, averaging


def test_a_run_ships_the_average_and_goes_on_from_the_latest_weights(tmp_path):
    folder, learner, averaging = averaging_run(tmp_path)
    state = folder.load()
    restore(learner.model, learner.discriminators, state, [averaging])
    assert equal(dict(learner.model.policy.state_dict()), dict(state["policy"]))
    actor = learner.model.policy.actor
    average = parameters_to_vector(actor.parameters())
    with averaging.average.learning():
        assert not torch.equal(parameters_to_vector(actor.parameters()), average)
        again = snapshot(learner.model, learner.discriminators, 0.0, [averaging])
    assert equal(again["policy"], state["policy"]) and equal(again["callbacks"], state["callbacks"])
    resume(folder.path, 1280, quiet=True)
    before, after = (run["callbacks"]["WeightAveraging 0"]["updates"] for run in (state, folder.load()))
    assert after == 2 * before > 0


def test_the_average_is_of_the_policy_that_was_restored(tmp_path):
    """Restoring builds a new actor where the old one was described otherwise, as after `--base` was written anew."""
    folder, learner, averaging = averaging_run(tmp_path)
    policy = learner.model.policy
    policy.assemble(policy.actor_from(policy.describe_actor()))
    restore(learner.model, learner.discriminators, folder.load(), [averaging])
    assert averaging.average.watches([w for w in policy.actor.parameters() if w.requires_grad])


def test_a_run_killed_before_its_first_checkpoint_may_begin_again(tmp_path):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    with pytest.raises(ValueError, match="holds a run already"):
        start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    folder.checkpoint.unlink()
    assert start(settings(tmp_path, samples=128), tmp_path / "run", quiet=True).load()["samples"] == 128


HOLDER = """
import sys, time
from pathlib import Path
from sb3_adaptnet.runs.lock import held
with held(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(600)
"""
"""A process that trains in a folder, as far as others can see."""


def test_two_processes_do_not_train_in_one_folder(tmp_path):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    files = {file: file.read_bytes() for file in folder.path.iterdir() if file.is_file()}
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(folder.path)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "held\n"
        with pytest.raises(ValueError, match=r"another process is at work in .*run; stop it"):
            resume(folder.path, 128, quiet=True)
        with pytest.raises(ValueError, match="another process is at work in"):
            start(settings(tmp_path, samples=64), folder.path, quiet=True)
        assert all(file.read_bytes() == content for file, content in files.items())
        process.kill()
        process.wait()
    assert resume(folder.path, 128, quiet=True).load()["samples"] == 128


def test_a_run_keeps_the_settings_it_began_with(tmp_path):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    conf(tmp_path, n_steps=4, batch_size=16)  # the file changes afterwards
    assert (
        folder.experiment.arguments["n_steps"] == 8
        and experiment(TOY, conf_file=conf(tmp_path, n_steps=4)).arguments["n_steps"] == 4
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


def test_a_run_goes_on_from_an_adaptation_and_its_card_names_it(tmp_path, tiny_base, two_styles):
    entry = conf(tmp_path, policy="sb3_adaptnet.AdaptNetPolicy", policy_kwargs={"critic_lr": 6.0e-4})
    words = ["train", TOY, "--conf-file", entry, "--base", str(tiny_base), "--samples", "64", "--quiet"]
    run = tmp_path / "run"
    assert main([*words, "--start", str(two_styles[1]), "--run-dir", str(run)]) == 0  # of low rank, unlike the entry's
    two_styles[1].unlink()  # a run that began does not need it
    with pytest.warns(UserWarning, match="of an adaptation to start from"):
        assert main(["train", "--resume", str(run), "--samples", "128", "--quiet"]) == 0
        card = json.loads(export(run, tmp_path / "on.st").with_suffix(".json").read_text())
    assert card["training"]["ppo"]["policy_kwargs"]["start"] == "limp" and card["shape"]["adaptors"] == "lora"
    assert str(tmp_path) not in json.dumps(card)


def test_a_run_without_its_start_leaves_nothing(tmp_path, tiny_base, capsys):
    entry = conf(tmp_path, policy="sb3_adaptnet.AdaptNetPolicy", policy_kwargs={"critic_lr": 6.0e-4})
    words = ["train", TOY, "--conf-file", entry, "--base", str(tiny_base), "--start", "nosuch.safetensors"]
    with pytest.warns(UserWarning, match="no file 'nosuch.safetensors' of an adaptation"):
        assert main([*words, "--run-dir", str(tmp_path / "run")]) == 2
    assert "nosuch.safetensors" in capsys.readouterr().err and not (tmp_path / "run").exists()


def test_a_run_whose_worlds_lack_an_objective_leaves_nothing(tmp_path, capsys):
    objectives = {"sb3_adaptnet.DiscriminatorRewardCallback": {"objective_weights": {"goal": 0.5, "footing": 0.5}}}
    words = ["train", TOY, "--conf-file", conf(tmp_path, callback=[objectives])]
    assert main([*words, "--run-dir", str(tmp_path / "run")]) == 2
    assert "'footing' needs environments with" in capsys.readouterr().err and not (tmp_path / "run").exists()


def test_a_run_can_be_resumed_from_its_first_moment(tmp_path):
    class Killed(Exception):
        pass

    class Killer(BaseCallback):
        def _on_step(self):
            raise Killed

    with pytest.raises(Killed):
        start(settings(tmp_path), tmp_path / "run", callbacks=[Killer()], quiet=True)
    folder = RunFolder.open(tmp_path / "run")
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


def train_command(tmp_path, *more):
    words = [
        "sb3_adaptnet.commands.main",
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
    process = run_command(["sb3_adaptnet.commands.main", "train", "--resume", str(folder.path), "--minutes", "99"])
    wait_for(lambda: csv_samples(folder) > max(saved, reached), process)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[0]
    assert process.returncode == 130 and "--resume" in said
    assert folder.load()["samples"] > saved
    assert len(list(folder.path.glob(".*.part"))) <= 1  # the kill may have come while a checkpoint was written


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
    training = card["training"]
    assert training["samples"] == 640 and card["environment"] == TOY and "metrics" not in card
    assert training["policy"] == "sb3_adaptnet.PretrainPolicy" and "terrain_seed" not in training
    rows = read_rows(folder.progress)[-10:]
    assert training["means_of_last_rollouts"]["rollouts"] == len(rows)
    mean = sum(row["goal_reward"] for row in rows) / len(rows)
    assert training["means_of_last_rollouts"]["goal_reward"] == pytest.approx(mean, abs=1e-4)
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


def test_a_resumed_run_refuses_changes_and_damage(tmp_path, capsys):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    assert main(["train", "--resume", str(folder.path), "--seed", "3"]) == 2
    assert main(["train", "Other-v0", "--resume", str(folder.path)]) == 2
    assert main(["train", TOY, "--conf-file", conf(tmp_path), "--run-dir", str(folder.path)]) == 2
    with pytest.raises(ValueError, match="there is no device 'nonsense'; the devices are cpu and cuda"):
        resume(folder.path, device="nonsense", quiet=True)
    assert RunFolder.open(folder.path).settings.device == "cpu"  # what failed is not remembered
    folder.checkpoint.write_bytes(folder.checkpoint.read_bytes()[:500])
    assert main(["train", "--resume", str(folder.path)]) == 2
    said = capsys.readouterr().err.splitlines()
    assert ["--seed" in said[0], "Other-v0" in said[1], "holds a run" in said[2], "cut short" in said[3]] == [True] * 4


def test_a_second_sigterm_waits_for_the_checkpoint(tmp_path):
    saver = RunSaver(RunFolder(tmp_path, settings(tmp_path)), None)
    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    with stopping(saver):
        for _ in range(2):
            signal.raise_signal(signal.SIGTERM)
        assert not saver._on_step()
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


@pytest.mark.parametrize("name", ["config.yml", "checkpoint.pt", "progress.csv"])
def test_a_run_writes_over_nothing_foreign(tmp_path, name):
    asked, path = settings(tmp_path), tmp_path / "run"
    path.mkdir()
    (path / name).write_text("mine: {precious: 1}")
    with pytest.raises(ValueError, match=f"holds {name} but no run.json of a run; choose another folder"):
        start(asked, path, quiet=True)
    assert [file.name for file in path.iterdir()] == [name]
    assert (path / name).read_text() == "mine: {precious: 1}"


def test_what_a_kill_left_of_a_checkpoint_goes_with_the_next_resume(tmp_path):
    folder = start(settings(tmp_path), tmp_path / "run", quiet=True)
    (folder.path / ".checkpoint.pt.123.part").write_bytes(b"half")
    resume(folder.path, quiet=True)
    assert not list(folder.path.glob(".*.part")) and folder.checkpoint.is_file()


def test_rows_that_are_none_are_left_out_and_other_files_named(tmp_path):
    file = tmp_path / "rows.csv"
    file.write_text("samples,goal\n1,0.5\ninf,1\nnan,1\nx,1\n,1\n2,0.6\n")
    assert read_rows(file) == [{"samples": 1, "goal": 0.5}, {"samples": 2, "goal": 0.6}]
    file.write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(ValueError, match="rows.csv is not a CSV file"):
        read_rows(file)
