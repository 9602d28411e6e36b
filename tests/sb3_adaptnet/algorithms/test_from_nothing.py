"""A policy and a world model that begin from nothing: recorded servos, fits when they are due, a base in the end."""

import numpy as np
import pytest
import torch
from policy_cases import SIZES
from world_cases import CHARACTER

from sb3_adaptnet import AdaptNetPolicy, AdaptVecEnv, PretrainPolicy, load_policy, save_base
from sb3_adaptnet.algorithms import model_based
from sb3_adaptnet.algorithms.model_learning import fit_anew, record
from sb3_adaptnet.algorithms.servo_regression import servo_aims
from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.algorithms.svg_settings import ModelFits
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.fitting.fit import loss_of, sample_starts
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.transitions import Transitions

WORLDS, STEPS = 6, 12


@pytest.fixture
def walk_worlds():
    return AdaptVecEnv("AdaptNet/Humanoid-Walk-v0", num_envs=WORLDS, num_threads=1, seed=0)


@pytest.fixture
def make(walk_worlds):
    def make(efforts=None, weight=0.25, **choices):
        fits = {"efforts": efforts or {0: 0.002}, "steps": STEPS, "width": 16}
        return SVG(
            PretrainPolicy, walk_worlds, "new", policy_kwargs=SIZES, model_fits=fits, guiding={"gaits": [0.9, 1.3]},
            n_steps=8, window=4, gradient_steps=2, regression_updates=3, model_refresh={"updates": 1, "batch": 16},
            cost_to_go={"updates": [3, 1], "weight": weight}, seed=0, device="cpu", **choices,
        )  # fmt: skip

    return make


def test_what_was_recorded_counts_and_the_inputs_are_known(make):
    model = make()
    assert model.policy.knows_nothing
    model.learn(WORLDS * (STEPS + 16))
    assert model.num_timesteps == WORLDS * (STEPS + 16)
    assert not model.policy.knows_nothing
    assert model.policy.actor.normalizer.count == 4 * STEPS * WORLDS
    assert (model.world_model.dynamics.input_scale != 1).any()


def test_of_an_adaptation_the_base_is_recorded(walk_base, monkeypatch):
    acted = []

    def watched(env, act, steps, rng):
        observations = env.reset()
        acted.append(np.allclose(act(observations), base.predict(observations, deterministic=True)[0]))
        return record(env, act, steps, rng)

    monkeypatch.setattr(model_based, "record", watched)
    env = AdaptVecEnv("AdaptNet/Humanoid-LockedAnklesWalk-v0", num_envs=WORLDS, num_threads=1, seed=0)
    base = load_policy(walk_base, env)
    model = SVG(
        AdaptNetPolicy, env, "new", policy_kwargs={"base": str(walk_base)},
        model_fits={"efforts": {0: 0.002}, "steps": STEPS, "width": 16}, guiding={"gaits": [0.9, 1.3]},
        n_steps=8, window=4, gradient_steps=2, regression_updates=0, model_refresh={"updates": 1, "batch": 16},
        cost_to_go={"updates": [3, 1]}, seed=0, device="cpu",
    )  # fmt: skip
    model.learn(WORLDS * (STEPS + 8))
    assert acted == [True]
    assert len(model.world_model.character.joints) == env.action_space.shape[0] < 28


def test_a_later_fit_begins_again_with_all_records(make):
    model = make({0: 0.002, 100: 0.002}, weight={0: 0.0, 110: 0.0, 111: 0.25})
    model.learn(WORLDS * STEPS + 48)  # one rollout: 120 samples
    assert (model.world_state()["fits_done"], len(model._recorded)) == (1, 1)
    statistics = model.world_model.dynamics.input_mean.clone()
    model.learn(48, reset_num_timesteps=False)  # due before the next one
    assert (model.world_state()["fits_done"], len(model._recorded)) == (2, 2)
    assert not torch.equal(model.world_model.dynamics.input_mean, statistics)
    model.learn(WORLDS * 8, reset_num_timesteps=False)
    assert model.world_state()["fits_done"] == 2


def test_the_base_that_was_learned_is_a_file_like_any_other(make, tmp_path):
    model = make().learn(WORLDS * (STEPS + 8))
    model.save(tmp_path / "model")
    loaded = SVG.load(tmp_path / "model", env=model.env, device="cpu")
    observations = model.env.reset()
    actions = model.predict(observations, deterministic=True)[0]
    assert np.array_equal(actions, loaded.predict(observations, deterministic=True)[0])
    loaded.learn(48, reset_num_timesteps=False)  # neither records nor guesses again
    assert loaded.num_timesteps == WORLDS * (STEPS + 16)
    policy = load_policy(save_base(model, tmp_path / "mine"), model.env)
    assert np.allclose(policy.predict(observations, deterministic=True)[0], actions, atol=1e-6)


def test_servos_that_follow_the_motion_stay_up_longer_than_limp_ones(walk_worlds):
    references = walk_worlds.simulation.reference_gaits([0.9, 1.3])
    motion = TrackedMotion.of(CHARACTER, torch.device("cpu"), references)
    ends = []
    for act in (servo_aims(motion), lambda seen: np.zeros((len(seen), 28), np.float32)):
        data, seen = record(walk_worlds, act, 60, np.random.default_rng(0))
        assert data.actions.shape == (60, WORLDS, 28)
        assert seen.shape == (60 * WORLDS, 784)
        ends.append(data.ended.sum())
    assert ends[0] < ends[1]


def test_a_fit_forgets_what_the_model_knew(walk_worlds):
    rng = np.random.default_rng(0)
    data, _ = record(walk_worlds, lambda seen: np.zeros((len(seen), 28), np.float32), 40, rng)
    data = Transitions.together([data, data])
    assert data.num_worlds == 2 * WORLDS
    model = WorldModel(CHARACTER, Sizes(32, 2))
    with torch.no_grad():
        model.dynamics.last.weight.fill_(9.0)
    shown = []
    fit_anew(model, data, 0.05, rng, lambda updates: (shown.append(len(updates)), updates)[1])
    assert shown == [60 + 25 + 20]
    guess = WorldModel(CHARACTER, Sizes(32, 2))
    guess.dynamics.load_state_dict({**guess.dynamics.state_dict(), **{
        name: model.dynamics.state_dict()[name]
        for name in ("input_mean", "input_scale", "output_mean", "output_std")
    }})  # fmt: skip
    starts = sample_starts(data, 1, 200, rng)
    assert loss_of(model, data, starts, 1) < 0.8 * loss_of(guess, data, starts, 1)


def test_a_fit_after_the_critic_began_is_refused(make):
    for weight in (0.25, {0: 0.0, 50: 0.25}, {0: 0.25, 100: 0.0}):
        with pytest.raises(ValueError, match="expected 0 until the last fit of the model, at 100"):
            make({0: 0.002, 100: 0.002}, weight=weight)


def test_fits_that_make_no_sense_are_refused():
    for wrong in (
        {"efforts": {100: 0.3}},
        {"efforts": 0.3},
        {"efforts": {}},
        {"efforts": {0: 0.0}},
        {"width": 0},
        {"steps": 0},
    ):
        with pytest.raises(ValueError, match=r"first fit|positive"):
            ModelFits(**wrong)
