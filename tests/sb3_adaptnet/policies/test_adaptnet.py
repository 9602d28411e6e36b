"""The policies on stock PPO: what learns, what stays, what they refuse."""

import copy
import warnings

import gymnasium as gym
import numpy as np
import pytest
import torch
from policy_cases import CASES, CHOICES, PPO_ARGUMENTS, SIZES, act, adapt, disturb, observations
from stable_baselines3 import PPO
from toy_env import ToyEnv, ToySpace

from sb3_adaptnet import (
    AdaptNetPolicy,
    CheckpointError,
    FinetunePolicy,
    PretrainPolicy,
    ProgressivePolicy,
    RegularizedFinetunePolicy,
    load_policy,
    save_base,
)

# -- the whole of training -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "heightmap"), CASES)
def test_training_moves_what_learns_and_nothing_else(name, heightmap, tiny_base):
    policy_class, choices = CHOICES[name]
    model = adapt(policy_class, ToyEnv(heightmap=heightmap), tiny_base, **choices)
    before = copy.deepcopy({k: v for k, v in model.policy.state_dict().items() if k != "_extra_state"})
    learning = {name for name, p in model.policy.named_parameters() if p.requires_grad}
    model.learn(64)
    after = model.policy.state_dict()
    frozen = [k for k in before if k not in learning and ".base." in k]
    assert frozen or name == "finetune"
    assert all(torch.equal(before[k], after[k]) for k in frozen)
    still = [k for k in learning if torch.equal(before[k], after[k])]
    assert not still
    assert np.isfinite(act(model.policy, heightmap)).all()


@pytest.mark.parametrize("name", [name for name, (kind, _) in CHOICES.items() if kind is not ProgressivePolicy])
def test_adapting_starts_exactly_at_the_base(name, tiny_base):
    policy_class, choices = CHOICES[name]
    base = load_policy(tiny_base, ToyEnv())
    model = adapt(policy_class, ToyEnv(), tiny_base, **choices)
    assert np.array_equal(act(model.policy), act(base))


def test_adapting_with_a_heightmap_starts_exactly_at_the_base(tiny_base):
    base = load_policy(tiny_base, ToyEnv())
    for policy_class in (AdaptNetPolicy, FinetunePolicy, RegularizedFinetunePolicy):
        model = adapt(policy_class, ToyEnv(heightmap=True), tiny_base)
        assert np.array_equal(act(model.policy, heightmap=True), act(base))


def test_alpha_zero_is_the_base_after_training_and_may_change_every_step(tiny_base):
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base)
    model.learn(64)
    disturb(model.policy.actor.adaptations)
    base = act(load_policy(tiny_base, ToyEnv()))
    adapted = act(model.policy)
    assert not np.allclose(adapted, base, atol=1e-3)
    for alpha, wanted in ((0.0, base), (1.0, adapted), (0.0, base)):
        model.policy.alpha = alpha
        assert np.array_equal(act(model.policy), wanted)
    model.policy.alpha = 0.5
    assert not np.allclose(act(model.policy), base, atol=1e-4)
    with pytest.raises(ValueError, match="finite"):
        model.policy.alpha = float("inf")


def test_log_std_stays_that_of_the_base_head(tiny_base):
    for policy_class in (AdaptNetPolicy, FinetunePolicy, RegularizedFinetunePolicy):
        policy = adapt(policy_class, ToyEnv(), tiny_base).policy
        heads = [p for name, p in policy.named_parameters() if "log_std" in name]
        assert heads
        assert not any(p.requires_grad for p in heads)


def test_first_ratio_is_one_after_statistics_moved(tiny_base):
    """Old and new log-probabilities see the same normaliser within a rollout and its update."""
    model = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS)
    model.learn(64)
    policy = model.policy
    policy.set_training_mode(False)
    obs = torch.from_numpy(observations())
    with torch.no_grad():
        actions, _, old = policy(obs)
        policy(obs * 3 + 1)
        policy.set_training_mode(True)
        _, new, _ = policy.evaluate_actions(obs, actions)
        assert torch.equal(old, new)
        policy.set_training_mode(False)
        moved = policy.evaluate_actions(obs, actions)[1]
    assert not torch.equal(old, moved)


@pytest.mark.parametrize("heightmap", [False, True])
def test_code_of_the_frozen_base_may_be_handed_back(heightmap, tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(heightmap=heightmap), tiny_base).policy
    disturb(policy.actor.adaptations)
    obs = observations(heightmap=heightmap)
    obs = {k: torch.from_numpy(v) for k, v in obs.items()} if heightmap else {"observation": torch.from_numpy(obs)}
    with torch.no_grad():
        actions, values, old = policy(obs if heightmap else obs["observation"])
        assert policy.base_code.shape == (6, 8)
        for kept in (obs, obs | {"base_code": policy.base_code}):
            again, new, _ = policy.evaluate_actions(kept, actions)
            assert torch.equal(new, old)
            assert torch.equal(again, values)
        _, other, _ = policy.evaluate_actions(obs | {"base_code": policy.base_code + 1}, actions)
    assert not torch.allclose(other, old)


def test_predicting_inside_a_rollout_does_not_move_the_statistics():
    policy = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS).policy
    policy.set_training_mode(False)
    with torch.no_grad():
        policy(torch.from_numpy(observations()))
        before = act(policy)
        policy(torch.from_numpy(observations(seed=9) * 4 + 2))
    assert np.array_equal(act(policy), before)


def test_long_rollout_warns_once_and_an_update_starts_the_count_again():
    policy = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS).policy
    half = torch.zeros(32_768, 784)
    with torch.no_grad(), warnings.catch_warnings():
        warnings.simplefilter("error")
        policy(half)
        policy(half)
        policy.set_training_mode(True)
        policy(half)
        policy(half)
        with pytest.raises(UserWarning, match="65,536"):
            policy(half[:1])
        policy(half[:1])


def test_same_seed_gives_the_same_weights(tiny_base):
    states = []
    for _ in range(2):
        model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base)
        model.env.seed(0)
        model.learn(128)
        states.append(model.policy.state_dict())
    assert all(torch.equal(states[0][key], states[1][key]) for key in states[0])


# -- objectives ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("weights", [(1.0,), (0.35, 0.65), (0.2, 0.3, 0.5)])
def test_objectives(weights, tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base).policy
    policy.set_objectives(weights)
    count, obs = len(weights), torch.from_numpy(observations())
    policy.value_norm.update(torch.randn(50, count) * 5 + 3)
    with torch.no_grad():
        actions, values, _ = policy(obs)
        normalized, _, entropy = policy.evaluate_actions(obs, actions)
        assert values.shape == normalized.shape == (6, count)
        assert entropy.shape == (6,)
        assert torch.allclose(policy.value_norm.denormalize(normalized), values, atol=1e-5)
        assert torch.allclose(policy.predict_objective_values(obs), values, atol=1e-5)
        wanted = (values * torch.tensor(weights)).sum(1, keepdim=True)
        assert torch.allclose(policy.predict_values(obs), wanted, atol=1e-5)
    trained = {id(p) for group in policy.optimizer.param_groups for p in group["params"]}
    assert trained == {id(p) for p in policy.parameters() if p.requires_grad}


def test_setting_the_same_number_of_objectives_keeps_the_critic():
    policy = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS).policy
    policy.set_objectives((0.5, 0.5))
    head, optimizer = policy.critic.head, policy.optimizer
    policy.set_objectives((0.35, 0.65))
    assert policy.critic.head is head
    assert policy.optimizer is optimizer
    with pytest.raises(ValueError, match="at least one"):
        policy.set_objectives(())


def test_optimizer_groups_carry_two_learning_rates(tiny_base):
    model = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, actor_lr=5e-6, critic_lr=1e-4)
    rates = {group["name"]: group["lr"] * group["lr_scale"] for group in model.policy.optimizer.param_groups}
    assert rates == pytest.approx({"actor": 5e-6, "critic": 1e-4})
    before = copy.deepcopy(dict(model.policy.named_parameters()))
    for parameter in model.policy.parameters():
        parameter.grad = torch.ones_like(parameter) if parameter.requires_grad else None
    model.policy.optimizer.step()
    moved = {name: (p - before[name]).abs().max().item() for name, p in model.policy.named_parameters()}
    assert moved["critic.head.linear.weight"] == pytest.approx(1e-4, rel=1e-2)
    assert moved["actor.adaptations.main.injector.maps.0.weight"] == pytest.approx(5e-6, rel=1e-2)
    assert moved["actor.base.mean.weight"] == 0.0


# -- precision -----------------------------------------------------------------------------------------------------


def test_bfloat16_keeps_heads_and_log_probabilities_in_float32(tiny_base):
    policy = adapt(AdaptNetPolicy, ToyEnv(), tiny_base, precision="bf16").policy
    policy.precision = "bf16"  # also on machines that would fall back to fp32
    exact = adapt(AdaptNetPolicy, ToyEnv(), tiny_base).policy
    obs = torch.from_numpy(observations())
    actions, values, old = policy(obs)
    _, new, _ = policy.evaluate_actions(obs, actions)
    assert old.dtype == values.dtype == actions.dtype == torch.float32
    assert torch.equal(old, new)
    assert torch.allclose(policy.get_distribution(obs).mode(), exact.get_distribution(obs).mode(), atol=0.05)
    (new.sum() + values.sum()).backward()
    assert all(torch.isfinite(p.grad).all() for p in policy.parameters() if p.grad is not None)


def test_unknown_precision_lists_the_known():
    with pytest.raises(ValueError, match=r"fp32.*medium.*bf16.*fp7"):
        PPO(PretrainPolicy, ToyEnv(), policy_kwargs={"precision": "fp7"})


# -- fewer joints --------------------------------------------------------------------------------------------------


def test_base_drops_the_joints_that_the_character_lacks(tiny_base):
    env = ToyEnv()
    whole = act(load_policy(tiny_base, env))
    few = ToyEnv(joints=5)
    few.action_space.joint_names = ("joint_7", "joint_2", "joint_20", "joint_0", "joint_27")
    for policy in (load_policy(tiny_base, few), adapt(AdaptNetPolicy, few, tiny_base).policy):
        assert np.allclose(act(policy), whole[:, [7, 2, 20, 0, 27]], atol=1e-6)
    few.action_space.joint_names = ("joint_7", "wing", "joint_20", "joint_0", "joint_27")
    with pytest.raises(ValueError, match="wing"):
        load_policy(tiny_base, few)


# -- run time ------------------------------------------------------------------------------------------------------


def test_blending_and_switching(two_styles, tiny_base):
    alone = [act(load_policy(file, ToyEnv(), base=tiny_base)) for file in two_styles]
    policy = load_policy(two_styles[0], ToyEnv(), base=tiny_base)
    name = policy.add_adaptation(two_styles[1])
    assert name == "limp"
    assert policy.weights == {"main": 1.0, "limp": 0.0}
    for weights, wanted in (({"main": 1.0}, alone[0]), ({"limp": 1.0}, alone[1])):
        policy.blend(weights)
        assert np.array_equal(act(policy), wanted)
    policy.blend({"main": 0.5, "limp": 0.5})
    assert not np.allclose(act(policy), alone[0], atol=1e-3)
    with pytest.raises(ValueError, match=r"limp.*already"):
        policy.add_adaptation(two_styles[1])


def test_merging_keeps_the_actions_and_then_fixes_alpha(two_styles, tiny_base):
    policy = load_policy(two_styles[0], ToyEnv(), base=tiny_base)
    policy.alpha = 0.8
    wanted = act(policy)
    policy.merge()
    assert np.allclose(act(policy), wanted, atol=1e-5)
    for forbidden in (policy.merge, lambda: setattr(policy, "alpha", 0.1), lambda: policy.blend({"main": 1.0})):
        with pytest.raises(ValueError, match="merged"):
            forbidden()


def test_adaptation_of_another_base_is_refused(two_styles, tmp_path):
    other = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=SIZES, **PPO_ARGUMENTS)
    file = save_base(other, tmp_path / "other")
    with pytest.raises(CheckpointError, match=r"adapts base 'tiny'.*not 'other'"):
        load_policy(two_styles[0], ToyEnv(), base=file)


# -- refusals ------------------------------------------------------------------------------------------------------


def test_missing_tiny_base_is_named_when_the_policy_acts(tmp_path):
    with pytest.warns(UserWarning, match=r"nowhere\.safetensors"):
        model = adapt(AdaptNetPolicy, ToyEnv(), tmp_path / "nowhere.safetensors")
    with pytest.raises(CheckpointError, match=r"nowhere\.safetensors"):
        model.learn(32)


def test_unknown_base_name_is_refused_at_once():
    with pytest.raises(CheckpointError, match="moonwalk"):
        adapt(AdaptNetPolicy, ToyEnv(), "moonwalk")


class PlainEnv(ToyEnv):
    def __init__(self):
        super().__init__()
        self.action_space = gym.spaces.Box(-1, 1, (28,), np.float32)


@pytest.mark.parametrize("policy_class", [AdaptNetPolicy, PretrainPolicy])
def test_plain_box_says_what_is_missing(policy_class):
    with pytest.raises(ValueError, match="joint_names"):
        PPO(policy_class, PlainEnv())


def test_action_space_with_wrong_names_is_refused():
    env = ToyEnv()
    env.action_space.joint_names = ("one", "two")
    with pytest.raises(ValueError, match="names 2 joints"):
        PPO(PretrainPolicy, env)
    assert isinstance(env.action_space, ToySpace)


def test_nothing_to_train_is_refused(tiny_base):
    with pytest.raises(ValueError, match="nothing to train"):
        adapt(AdaptNetPolicy, ToyEnv(), tiny_base, injector=False, adaptors=None)


def test_state_dependent_noise_is_refused():
    with pytest.raises(ValueError, match="use_sde"):
        PPO(PretrainPolicy, ToyEnv(), use_sde=True)


def test_a_held_standard_deviation_stays_and_survives_saving(tmp_path):
    choices = SIZES | {"learn_std": False, "initial_std": 0.1}
    model = PPO(PretrainPolicy, ToyEnv(), policy_kwargs=choices, **PPO_ARGUMENTS)
    model.learn(64)
    model.save(tmp_path / "held")
    again = PPO.load(tmp_path / "held", env=ToyEnv())
    again.learn(64)
    for policy in (model.policy, again.policy):
        spread = policy.get_distribution(torch.as_tensor(observations())).distribution.stddev
        assert torch.allclose(spread, torch.full_like(spread, 0.1))
