"""The callback on stock PPO: rewards, bootstraps and advantages of K objectives, on any vector environment."""

import re

import numpy as np
import pytest
import torch
from objective_cases import DISCRIMINATOR, SMALL, Check, make_callback, make_model, standardised_advantages
from stable_baselines3 import A2C, PPO
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecMonitor, VecNormalize
from toy_env import ToyEnv, ToyVectorEnv

from sb3_adaptnet import (
    AdaptVecEnv,
    DiscriminatorRewardCallback,
    PretrainPolicy,
)
from sb3_adaptnet.modules.layers import precision
from sb3_adaptnet.policies.optimizer_groups import step_size


@pytest.mark.parametrize("k", [1, 2, 3])
def test_returns_by_a_plain_loop(k):
    """Terminal rewards, bootstraps of time limits and of the rollout's end, objective by objective, world by world."""
    callback = make_callback(k, terminal_reward=-7.0)
    seen = {"limits": 0, "falls": 0}

    def check(model):
        rollout, buffer, policy = callback.rollout, model.rollout_buffer, model.policy

        def values_of(observations):
            with torch.no_grad():
                return policy.predict_objective_values(torch.as_tensor(np.asarray(observations))).numpy()

        limits = {(step, world): values_of(obs[None])[0] for step, world, obs in rollout.time_limits}
        last = values_of(callback.locals["new_obs"])
        expected = np.zeros_like(buffer.returns)
        for world in range(16):
            for column, name in enumerate(callback.objectives):
                following, advantage = last[world, column], 0.0
                for step in reversed(range(16)):
                    reward, value = rollout.rewards[name][step, world], buffer.values[step, world, column]
                    if rollout.terminated[step, world]:
                        target, advantage = -7.0, 0.0
                    elif (step, world) in limits:
                        target, advantage = reward + 0.9 * limits[step, world][column], 0.0
                    else:
                        target = reward + 0.9 * following
                    advantage = target - value + 0.9 * 0.8 * advantage
                    expected[step, world, column] = advantage + value
                    following = value
        np.testing.assert_allclose(buffer.returns, expected, rtol=2e-3, atol=2e-3)
        seen["limits"] += len(limits)
        seen["falls"] += int(rollout.terminated.sum())

    make_model().learn(16 * 16 * 5, callback=[callback, Check(check)])
    assert seen["limits"] > 0 and seen["falls"] > 0  # otherwise nothing was tested


def test_goal_reward_is_the_environments_own():
    """PPO adds its own bootstrap to the rewards in place; the copied ones stay below 1."""
    callback = make_callback()
    check = Check(lambda model: np.testing.assert_array_less(callback.rollout.rewards["goal"], 1.0 + 1e-6))
    make_model().learn(16 * 16 * 5, callback=[callback, check])
    assert check.calls == 5


def test_advantages_are_standardised_and_weighted():
    callback = make_callback(2)

    def check(model):
        buffer = model.rollout_buffer
        standard = standardised_advantages(buffer)
        np.testing.assert_allclose(buffer.advantages, standard @ [0.35, 0.65], rtol=1e-3, atol=1e-4)
        assert not model.normalize_advantage

    model = make_model()
    assert model.normalize_advantage
    model.learn(16 * 16 * 2, callback=[callback, Check(check)])
    assert model.normalize_advantage  # put back


@pytest.mark.parametrize("make", [
    lambda: DummyVecEnv([ToyEnv] * 4),
    lambda: SubprocVecEnv([ToyEnv] * 2),
    lambda: VecMonitor(AdaptVecEnv(ToyVectorEnv(4))),
    lambda: AdaptVecEnv(ToyVectorEnv(4, heightmap=True)),
    lambda: DummyVecEnv([lambda: ToyEnv(heightmap=True)] * 2),
], ids=["dummy", "subproc", "wrapped", "native-dict", "dummy-dict"])  # fmt: skip
def test_every_vector_environment(make):
    callback = make_callback()
    model = make_model(make())
    model.learn(16 * model.n_envs * 2, callback=callback)
    assert np.isfinite(list(callback.metrics.values())).all()
    assert callback.metrics["imitation_reward"] != 0.0
    model.env.close()


@pytest.mark.parametrize("env", [lambda: ToyEnv(), lambda: AdaptVecEnv(ToyVectorEnv(4))], ids=["single", "native"])
def test_stock_ppo_without_the_callback(env):
    model = make_model(env())
    model.learn(64)
    assert model.rollout_buffer.values.ndim <= 2


def test_same_seed_same_weights_after_ten_updates():
    states = []
    for _ in range(2):
        model = make_model(AdaptVecEnv(ToyVectorEnv(4)), seed=3)
        model.learn(16 * 4 * 10, callback=make_callback())
        states.append(model.policy.state_dict())
    assert all(torch.equal(states[0][name], states[1][name]) for name in states[0])


def test_actor_step_size_follows_the_kl():
    model, callback = make_model(learning_rate=1e-4), make_callback(kl_range=(0.5, 0.9), actor_lr_range=(1e-6, 2e-4))
    model.learn(16 * 16 * 4, callback=callback)  # a KL far below the range: the step size grows to its bound
    assert step_size(model.policy.optimizer, "actor") == pytest.approx(2e-4)
    assert step_size(model.policy.optimizer, "critic") == 1e-4


def test_weights_change_with_the_samples():
    weights = {"imitation": {0: 0.6, 256: 0.6, 768: 0.2}, "goal": {0: 0.4, 256: 0.4, 768: 0.8}}
    callback, seen = DiscriminatorRewardCallback(weights, discriminator=DISCRIMINATOR), []

    def check(model):
        buffer = model.rollout_buffer
        standard = standardised_advantages(buffer)
        seen.append(np.linalg.lstsq(standard.reshape(-1, 2), buffer.advantages.reshape(-1), rcond=None)[0])

    model = make_model()
    model.learn(16 * 16 * 5, callback=[callback, Check(check)])
    # A rollout of 256 samples has the weights of its start.
    np.testing.assert_allclose(seen, [(0.6, 0.4), (0.6, 0.4), (0.4, 0.6), (0.2, 0.8), (0.2, 0.8)], atol=1e-3)
    assert model.policy.objective_weights == pytest.approx((0.2, 0.8))


def test_a_run_goes_on_with_the_same_callback():
    model, callback = make_model(), make_callback()
    model.learn(16 * 16, callback=callback)
    discriminator = callback.imitation.discriminator
    model.learn(16 * 16, callback=callback, reset_num_timesteps=False)
    assert callback.imitation.discriminator is discriminator


def test_learning_again_without_the_callback_says_what_is_missing():
    model = make_model()
    model.learn(16 * 16, callback=make_callback())
    with pytest.raises(RuntimeError, match="DiscriminatorRewardCallback"):
        model.learn(16 * 16)


def test_refuses_what_it_cannot_use():
    with pytest.raises(ValueError, match="discriminators' arguments are learning_rate.*share.*, not 'shares'"):
        DiscriminatorRewardCallback(discriminator={"shares": 0.5})
    with pytest.raises(ValueError, match="network's arguments are heads, gru, hidden, not 'gru_size'"):
        DiscriminatorRewardCallback(discriminator={"network": {"gru_size": 128}})
    with pytest.raises(ValueError, match="'speed'.*imitation, goal"):
        DiscriminatorRewardCallback({"speed": 1.0})
    with pytest.raises(ValueError, match="'goal'.*-0.1"):
        DiscriminatorRewardCallback({"goal": -0.1})
    with pytest.raises(ValueError, match="'goal'.*-0.2"):
        DiscriminatorRewardCallback({"goal": {0: 0.5, 1000: -0.2}})
    for weight in ({}, "heavy", {"1e6": 0.5}, float("nan")):
        with pytest.raises(ValueError, match=r"'goal' must be a number or \{samples: number\}"):
            DiscriminatorRewardCallback({"goal": weight})
    with pytest.raises(ValueError, match="kl_range"):
        DiscriminatorRewardCallback(kl_range=(0.03, 0.012))
    for name, value in (("kl_range", 0.02), ("kl_range", [0.02]), ("actor_lr_range", 1e-4)):
        with pytest.raises(
            ValueError, match=rf"{name} must be two values, as in \[1, 2\], not {re.escape(repr(value))}"
        ):
            DiscriminatorRewardCallback(**{name: value})
    with pytest.raises(ValueError, match="each bound of actor_lr_range must be a number"):
        DiscriminatorRewardCallback(actor_lr_range=["1e-6", 1e-3])
    a2c = A2C("MlpPolicy", DummyVecEnv([ToyEnv]), n_steps=16)
    with pytest.raises(ValueError, match="goes with PPO, not with A2C"):
        a2c.learn(16, callback=make_callback())
    stock = PPO("MlpPolicy", DummyVecEnv([ToyEnv]), n_steps=16)
    with pytest.raises(ValueError, match="PretrainPolicy.*ActorCriticPolicy"):
        stock.learn(16, callback=make_callback())
    bare = PPO(PretrainPolicy, DummyVecEnv([_WithoutWindows]), n_steps=16, policy_kwargs=dict(SMALL))
    with pytest.raises(ValueError, match="sample_reference_windows"):
        bare.learn(16, callback=make_callback())


class _WithoutWindows(ToyEnv):
    def __getattribute__(self, name):
        if name == "sample_reference_windows":
            raise AttributeError(name)
        return super().__getattribute__(name)


def test_vec_normalize_is_refused():
    with pytest.raises(ValueError, match="leave VecNormalize out"):
        make_model(VecNormalize(AdaptVecEnv(ToyVectorEnv(4)))).learn(64, callback=make_callback())


def test_another_model_gets_discriminators_of_its_own():
    callback, first = make_callback(), make_model(AdaptVecEnv(ToyVectorEnv(4)))
    first.learn(64, callback=callback)
    kept = callback.imitation
    first.learn(64, callback=callback)
    assert callback.imitation is kept
    make_model(AdaptVecEnv(ToyVectorEnv(4))).learn(64, callback=callback)
    assert callback.imitation is not kept


def test_the_stock_setting_returns_however_often_the_callback_was_initialised():
    callback, model = make_callback(), make_model(AdaptVecEnv(ToyVectorEnv(4)))
    model.normalize_advantage = True
    callback.init_callback(model)
    model.learn(64, callback=callback)
    assert model.normalize_advantage


def test_discriminators_have_the_precision_of_the_device_or_their_own(monkeypatch):
    """As where the processor has no bfloat16, which the policy is built on, and the card has."""
    model = make_model(AdaptVecEnv(ToyVectorEnv(4)), precision="auto")
    monkeypatch.setattr(precision, "has_bf16", lambda device="cpu": device == model.device)
    callback = make_callback()
    model.learn(64, callback=callback)
    assert (callback.imitation.precision, model.policy.precision) == ("bf16", "bf16")
    with pytest.raises(ValueError, match="unknown precision 'bf17'; choose one of: fp32"):
        model.learn(64, callback=DiscriminatorRewardCallback(discriminator={"precision": "bf17"}))
