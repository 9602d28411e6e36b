"""What of `config.yml` may change in a resumed run, and what a stopped or cut one keeps."""

import signal

import pytest
import torch
import yaml
from stable_baselines3.common.callbacks import BaseCallback
from toy_zoo import ENTRY, TOY, conf, settings

from sb3_adaptnet.commands.main import main
from sb3_adaptnet.policies.optimizer_groups import ACTOR, CRITIC, restore_moments, step_size
from sb3_adaptnet.policies.scaled_adam import ScaledAdam
from sb3_adaptnet.runs.history import read_rows
from sb3_adaptnet.runs.saver import restore
from sb3_adaptnet.runs.training import build_learner, check_device, resume, start


def edited(folder, change):
    """Change the entry in a run's `config.yml`."""
    entries = yaml.safe_load(folder.config.read_text())
    change(entries[TOY])
    folder.config.write_text(yaml.safe_dump(entries))


def restored(folder):
    """The learner of a run as a resumed one would have it."""
    learner = build_learner(folder.settings, folder.experiment, samples_done=64)
    learner.discriminators.init_callback(learner.model)
    restore(learner.model, learner.discriminators, folder.load())
    return learner


def test_step_sizes_that_the_training_does_not_set_may_change(tmp_path):
    folder = start(settings(tmp_path, samples=320), tmp_path / "run", quiet=True)

    def other_rates(entry):
        entry["policy_kwargs"] |= {"critic_lr": 0.02, "optimizer_kwargs": {"eps": 0.5}}
        entry["callback"][0]["sb3_adaptnet.DiscriminatorRewardCallback"]["discriminator"]["learning_rate"] = 0.1

    steered = step_size(restored(folder).model.policy.optimizer, ACTOR)
    edited(folder, other_rates)
    learner = restored(folder)
    optimizer, discriminators = learner.model.policy.optimizer, learner.discriminators.imitation.optimizer
    assert step_size(optimizer, CRITIC) == pytest.approx(0.02) and optimizer.param_groups[0]["eps"] == 0.5
    assert discriminators.param_groups[0]["lr"] == 0.1 and discriminators.state_dict()["state"]
    assert step_size(optimizer, ACTOR) == steered != pytest.approx(3.0e-4)  # what the KL range has made of it


def test_a_step_size_that_was_set_in_training_survives_another_rate():
    def adam(rate, scale):
        return ScaledAdam([{"params": [torch.nn.Parameter(torch.ones(1))], "name": ACTOR, "lr_scale": scale}], lr=rate)

    before, after, free = adam(1.0e-3, 0.5), adam(2.0e-3, 1.0), adam(2.0e-3, 1.0)
    restore_moments(after, before.state_dict(), (ACTOR,))
    restore_moments(free, before.state_dict())
    assert step_size(after, ACTOR) == pytest.approx(5.0e-4) and step_size(free, ACTOR) == pytest.approx(2.0e-3)


@pytest.mark.parametrize(
    "change, complaint",
    [
        (lambda entry: entry["policy_kwargs"].update(gru_size=16), "config.yml changes the policy's networks"),
        (lambda entry: entry["policy_kwargs"].update(critic={"hidden_sizes": [32]}), "config.yml changes the policy's"),
        (
            lambda entry: entry["callback"][0]["sb3_adaptnet.DiscriminatorRewardCallback"]["discriminator"].update(
                network={"gru": 16, "hidden": [8], "heads": 4}
            ),
            "the discriminators that learned before had another network",
        ),
    ],
)
def test_networks_stay_what_they_are(tmp_path, capsys, change, complaint):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    edited(folder, change)
    assert main(["train", "--resume", str(folder.path), "--samples", "128", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert complaint in said and said.count("\n") == 1
    assert folder.load()["samples"] == 64


def test_what_is_measured_no_longer_keeps_its_column(tmp_path):
    ramp = {"sb3_adaptnet.AttributeRamp": {"attribute": "drift", "first": 0.1, "last": 0.2, "samples": 64}}
    asked = settings(tmp_path, samples=64)
    conf(tmp_path, callback=[*ENTRY["callback"], ramp])
    folder = start(asked, tmp_path / "run", quiet=True)
    edited(folder, lambda entry: entry["callback"].pop())
    resume(folder.path, 128, quiet=True)
    first, second = read_rows(folder.progress)
    assert first["drift"] > 0 and "drift" not in second and second["goal_reward"] > 0


def test_a_row_that_was_cut_short_is_left_out(tmp_path):
    file = tmp_path / "progress.csv"
    file.write_bytes(b"samples,goal_reward\r\n64,0.5\r\n128,0.2")
    assert read_rows(file) == [{"samples": 64, "goal_reward": 0.5}]
    file.write_bytes(b"samples,goal_reward\r\n64,0.5\r\n128,0.25\r\n")
    assert [row["goal_reward"] for row in read_rows(file)] == [0.5, 0.25]


class StopsInside(BaseCallback):
    """Asks for the end in the middle of a rollout, as Ctrl-C does."""

    def _on_step(self):
        if self.num_timesteps == 64 + 24:
            signal.raise_signal(signal.SIGINT)
        return True


def test_a_rollout_that_was_cut_does_not_count(tmp_path):
    folder = start(settings(tmp_path, samples=320), tmp_path / "run", callbacks=[StopsInside()], quiet=True)
    state = folder.load()
    assert (state["samples"], state["updates"]) == (64, 1)
    assert [row["samples"] for row in read_rows(folder.progress)] == [64]
    assert resume(folder.path, quiet=True).load()["samples"] == 320


def test_a_new_run_may_take_the_place_of_an_old_one_once_nothing_speaks_against_it(tmp_path):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    (folder.path / "note.txt").write_text("x")
    with pytest.raises(ValueError, match="there is no device 'tpu'"):
        start(settings(tmp_path, samples=64, device="tpu"), folder.path, anew=True, quiet=True)
    assert folder.load()["samples"] == 64 and (folder.path / "note.txt").exists()
    assert start(settings(tmp_path, samples=128), folder.path, anew=True, quiet=True).load()["samples"] == 128
    assert not (folder.path / "note.txt").exists()


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a graphics card")
def test_a_device_that_is_not_there_is_refused(tmp_path, capsys):
    assert (
        main(["train", TOY, "--conf-file", conf(tmp_path), "--device", "cuda", "--run-dir", str(tmp_path / "r")]) == 2
    )
    assert "device 'cuda' needs a graphics card" in capsys.readouterr().err and not (tmp_path / "r").exists()
    check_device("cpu")


@pytest.mark.parametrize(
    "changes, complaint",
    [
        ({"n_envs": None}, "n_envs is None, expected a number of at least 1"),
        ({"n_timesteps": "2e6"}, "write 2000000.0 instead of 2e6"),
        ({"batch_size": 1, "normalize_advantage": True}, "its settings cannot be used"),
        ({"policy_kwargs": {"gru_size": "big"}}, "its settings cannot be used"),
    ],
)
def test_settings_of_a_wrong_kind_are_one_sentence(tmp_path, capsys, changes, complaint):
    words = ["train", TOY, "--conf-file", conf(tmp_path, **changes), "--run-dir", str(tmp_path / "run"), "--quiet"]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert complaint in said and said.count("\n") == 1 and not (tmp_path / "run").exists()


def test_a_checkpoint_of_something_else_is_refused(tmp_path):
    folder = start(settings(tmp_path, samples=64), tmp_path / "run", quiet=True)
    torch.save({}, folder.checkpoint)
    with pytest.raises(ValueError, match="is not a checkpoint of this program"):
        resume(folder.path, quiet=True)
