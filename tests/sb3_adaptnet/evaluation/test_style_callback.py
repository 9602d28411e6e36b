"""What is measured while a policy learns, and that learning does not notice."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from evaluation_cases import STOOP, save_tiny_base
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback, CallbackList
from stable_baselines3.common.logger import configure
from toy_env import ToyEnv, ToyVectorEnv
from toy_zoo import ENTRY, conf, settings

from sb3_adaptnet import AdaptNetPolicy, AdaptVecEnv, DiscriminatorRewardCallback, PretrainPolicy, WeightAveraging
from sb3_adaptnet.evaluation import StyleCallback, style_callback
from sb3_adaptnet.runs.training import start

PPO_SETTINGS = {"n_steps": 8, "batch_size": 16, "n_epochs": 1, "normalize_advantage": False, "seed": 3, "verbose": 0}


def callbacks_of(**arguments):
    discriminators = DiscriminatorRewardCallback(
        {"imitation": 0.5, "goal": 0.5}, discriminator={"batch_size": 16, "network": {"gru": 8, "hidden": [8]}}
    )
    return [discriminators, StyleCallback(**arguments)]


def learned(base, callbacks, samples=64, logger=None):
    env = AdaptVecEnv(STOOP, num_envs=4, num_threads=1, seed=0)
    model = PPO(AdaptNetPolicy, env, policy_kwargs={"base": base}, **PPO_SETTINGS)
    if logger is not None:
        model.set_logger(logger)
    return model.learn(samples, callback=callbacks)


def test_learning_does_not_notice_the_measuring(tmp_path):
    base = save_tiny_base(tmp_path)
    with_it, without = callbacks_of(samples=40, share=1e9), callbacks_of(samples=10**9)
    states = [learned(base, callbacks).policy.state_dict() for callbacks in (with_it, without)]
    assert with_it[1].metrics["visible"] == 0.0 and not without[1].metrics
    assert states[0].keys() == states[1].keys() and all(torch.equal(states[0][k], states[1][k]) for k in states[0])


def test_at_the_start_an_adaptation_is_measured_as_its_base(tmp_path):
    callbacks = callbacks_of(samples=1, share=1e9)
    learned("walk", callbacks, 8, configure(str(tmp_path), ["csv"]))
    with (tmp_path / "progress.csv").open() as stream:
        logged = {name: float(value) for name, value in next(csv.DictReader(stream)).items() if value}
    assert logged["style/tempo_error_m"] == logged["style/base_tempo_error_m"] == pytest.approx(0.145, abs=0.02)
    assert logged["style/visible"] == 0 and logged["style/clip_cadence_hz"] == pytest.approx(1.07, abs=0.01)
    assert set(callbacks[1].metrics) == set(StyleCallback.columns)


class StopAfter(BaseCallback):
    """Ends training behind a measurement, and keeps the weights of then."""

    def __init__(self, enough, averaging):
        super().__init__()
        self.enough, self.averaging, self.average, self.latest = enough, averaging, [], []

    def _on_rollout_end(self):
        if self.enough() and not self.average:
            weights = list(self.model.policy.actor.parameters())
            self.latest = [weight.detach().clone() for weight in weights]
            with self.averaging.average.acting():
                self.average = [weight.detach().clone() for weight in weights]

    def _on_step(self):
        return not self.average


@pytest.fixture
def clock(monkeypatch):
    """A clock that measuring moves on by 5 s, in worlds that are always visible."""
    now = SimpleNamespace(seconds=0.0, measured=[])

    def measure(policy):
        now.measured.append(now.seconds)
        now.seconds += 5.0
        return {"visible": True, "cadence_hz": 1.5, "failed_tests": [], "tempo_error_m": None}

    worlds = SimpleNamespace(measure=measure, env=SimpleNamespace(close=lambda: None))
    monkeypatch.setattr(style_callback, "time", SimpleNamespace(monotonic=lambda: now.seconds))
    monkeypatch.setattr(style_callback._StyleWorlds, "like", lambda *_: worlds)
    return now


class Training(StyleCallback):
    """Lets every rollout take 10 s."""

    def __init__(self, clock, **arguments):
        super().__init__(**arguments)
        self.clock = clock

    def _on_rollout_end(self):
        self.clock.seconds += 10.0
        super()._on_rollout_end()


@pytest.mark.parametrize("samples, share, times", [
    (64, 1.0, [10, 25, 40, 55]), (128, 1.0, [20, 45]), (64, 0.2, [10, 55]), (10**6, 1.0, []),
])  # fmt: skip
def test_measuring_comes_after_so_many_samples_and_takes_its_share_at_most(clock, samples, share, times):
    model = PPO(PretrainPolicy, AdaptVecEnv(ToyVectorEnv(8)), policy_kwargs=ENTRY["policy_kwargs"], **PPO_SETTINGS)
    callback = Training(clock, samples=samples, share=share)
    model.learn(5 * 64 - 64 * (share == 1.0), callback=[DiscriminatorRewardCallback({"goal": 1.0}), callback])
    assert clock.measured == times


@pytest.mark.parametrize("within", [list, lambda callbacks: CallbackList([CallbackList(callbacks)])])
def test_the_average_is_measured_where_there_is_one(within, monkeypatch):
    measured = []

    def measure(policy):
        measured.append([weight.detach().clone() for weight in policy.actor.parameters()])
        return {}

    monkeypatch.setattr(style_callback._StyleWorlds, "like", lambda *_: SimpleNamespace(measure=measure, env=ToyEnv()))
    model = PPO(PretrainPolicy, AdaptVecEnv(ToyVectorEnv(8)), policy_kwargs=ENTRY["policy_kwargs"], **PPO_SETTINGS)
    averaging, callback = WeightAveraging(0.9), StyleCallback(samples=64, share=1e9)
    stop = StopAfter(lambda: len(measured) == 3, averaging)
    model.learn(10**4, callback=within([DiscriminatorRewardCallback({"goal": 1.0}), averaging, callback, stop]))
    wanted, latest = stop.average, stop.latest
    assert all(map(torch.equal, measured[-1], wanted))
    assert not all(map(torch.equal, measured[-1], latest))


def test_what_was_measured_is_in_the_runs_progress(clock, tmp_path):
    entries = [*ENTRY["callback"], {"sb3_adaptnet.evaluation.StyleCallback": {"samples": 128, "share": 10.0}}]
    asked = settings(tmp_path)
    conf(tmp_path, callback=entries)
    folder = start(asked, tmp_path / "run", quiet=True)
    with folder.progress.open() as stream:
        rows = list(csv.DictReader(stream))
    assert [bool(row["cadence_hz"]) for row in rows] == [n % 2 == 1 for n in range(10)]
    assert {(row["visible"], row["cadence_hz"], row["tempo_error_m"]) for row in rows[1::2]} == {("1.0", "1.5", "")}
    assert all(np.isfinite(float(row["discriminator_score_difference"])) for row in rows)


def test_other_worlds_are_not_measured():
    callback = StyleCallback(samples=1, share=1e9)
    model = PPO(PretrainPolicy, AdaptVecEnv(ToyVectorEnv(8)), policy_kwargs=ENTRY["policy_kwargs"], **PPO_SETTINGS)
    model.learn(128, callback=[DiscriminatorRewardCallback({"goal": 1.0}), callback])
    assert not callback.metrics
