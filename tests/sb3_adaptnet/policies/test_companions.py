"""Learning beside frozen adaptations: it acts as the sum that is stacked later, and nothing of them learns."""

import numpy as np
import pytest
import torch
from objective_cases import Check, standardised_advantages
from policy_cases import adapt, disturb, observations
from stable_baselines3 import PPO
from toy_env import ToyEnv, ToyVectorEnv

from sb3_adaptnet import AdaptNetPolicy, AdaptVecEnv, DiscriminatorRewardCallback, load_policy, save_adaptation
from sb3_adaptnet.stacking import JoinedWorlds

DISCRIMINATOR = {"batch_size": 32, "network": {"gru": 8, "hidden": [8], "heads": 4}}
NUMBERS = np.array([2, 0, 1, 1, 0, 2])


def worlds(heightmap=False):
    return JoinedWorlds([AdaptVecEnv(ToyVectorEnv(2, heightmap)) for _ in range(3)])


def learner(tiny_base, two_styles, heightmap=False, **choices):
    return adapt(AdaptNetPolicy, worlds(heightmap), tiny_base, companions=[str(f) for f in two_styles], **choices)


def batch(heightmap=False):
    found = observations(heightmap=heightmap)
    return {**(found if heightmap else {"observation": found}), "companion": NUMBERS}


@pytest.mark.parametrize("heightmap", [False, True])
def test_each_world_acts_as_the_stack_with_its_companion(heightmap, tiny_base, two_styles, tmp_path):
    policy = learner(tiny_base, two_styles, heightmap).policy
    disturb(policy.actor.adaptations)
    together = policy.predict(batch(heightmap), deterministic=True)[0]
    stacked = load_policy(save_adaptation(policy, tmp_path / "mine"), ToyEnv(heightmap=heightmap), base=tiny_base)
    names = [stacked.add_adaptation(file) for file in two_styles]
    apart = []
    for name in (None, *names):
        stacked.blend({"main": 1.0} if name is None else {"main": 1.0, name: 1.0})
        apart.append(stacked.predict(observations(heightmap=heightmap), deterministic=True)[0])
    expected = np.stack([apart[number][row] for row, number in enumerate(NUMBERS)])
    np.testing.assert_allclose(together, expected, atol=1e-5)
    assert len({tuple(actions[0]) for actions in apart}) == 3


def test_what_a_companion_adds_to_the_latents_may_be_handed_back(tiny_base, two_styles):
    policy = learner(tiny_base, two_styles).policy
    disturb(policy.actor.adaptations)
    obs = {key: torch.from_numpy(values) for key, values in batch().items()}
    with torch.no_grad():
        actions, _, old = policy(obs)
        kept = policy.remembered
        widths = {"base_code": 8, "companion_offset": 12, "companion_mean": 28}
        assert {key: values.shape for key, values in kept.items()} == {key: (6, n) for key, n in widths.items()}
    for given in (obs, obs | kept):
        torch.testing.assert_close(policy.evaluate_actions(given, actions)[1], old, rtol=1e-5, atol=1e-5)
    with torch.no_grad():
        moved = obs | kept | {"companion_offset": kept["companion_offset"] + 1}
        assert not torch.allclose(policy.evaluate_actions(moved, actions)[1], old)


def test_it_stays_near_what_its_companions_do_alone(tiny_base, two_styles):
    """Nothing else has a gradient here: PPO's loss of advantages of 0."""
    policy = learner(tiny_base, two_styles, beta=0.0, kappa=0.0, companion_kl=None).policy
    obs = {key: torch.from_numpy(values) for key, values in batch().items()}
    alone = policy.get_distribution(obs).distribution.mean.detach()
    disturb(policy.actor.adaptations)
    with torch.no_grad():
        torch.testing.assert_close(policy.actor.companions_alone(policy._split(obs)), alone)
    distribution = policy.get_distribution(obs).distribution
    there, here = (torch.distributions.Normal(x, distribution.stddev.detach()) for x in (alone, distribution.mean))
    divergences = torch.distributions.kl_divergence(here, there).sum(dim=1)
    free = divergences.mean().item()
    (0.01 * (divergences - free).clamp_min(0).mean()).backward()
    wanted = [p.grad for p in policy.actor.adaptations.parameters()]
    policy.zero_grad()
    policy.actor.penalties = policy.actor.penalties._replace(companion_kl=free)
    (0.0 * policy.get_distribution(obs).distribution.mean).sum().backward()
    for gradient, parameter in zip(wanted, policy.actor.adaptations.parameters(), strict=True):
        torch.testing.assert_close(parameter.grad, gradient, rtol=1e-4, atol=1e-7)
    assert max(gradient.abs().max() for gradient in wanted) > 1e-3
    policy.zero_grad()
    with policy.actor.one_update(3):  # each pass pays its share
        sum((0.0 * policy.get_distribution(obs).distribution.mean).sum() for _ in range(3)).backward()
    for gradient, parameter in zip(wanted, policy.actor.adaptations.parameters(), strict=True):
        torch.testing.assert_close(parameter.grad, gradient, rtol=1e-4, atol=1e-7)


@pytest.mark.parametrize(("name", "valid"), [("beta", ""), ("kappa", ""), ("companion_kl", ", or None")])
@pytest.mark.parametrize("wrong", [-1.0, float("inf"), float("nan"), "much"])
def test_what_is_no_penalty_is_refused(name, valid, wrong, tiny_base, two_styles):
    with pytest.raises(ValueError, match=f"{name} must be a finite number that is at least 0{valid}, not {wrong!r}"):
        learner(tiny_base, two_styles, **{name: wrong})


@pytest.mark.parametrize("heightmap", [False, True])
def test_only_its_own_weights_learn_and_a_saved_model_goes_on(heightmap, tiny_base, two_styles, tmp_path):
    model = learner(tiny_base, two_styles, heightmap)
    before = {name: p.clone() for name, p in model.policy.actor.companions.named_parameters()}
    callback = DiscriminatorRewardCallback(discriminator=DISCRIMINATOR)
    model.learn(192, callback=callback)
    assert before and all(torch.equal(p, before[n]) for n, p in model.policy.actor.companions.named_parameters())
    assert any(p.abs().max() > 0 for p in model.policy.actor.adaptations["main"].adaptors.parameters())
    model.save(tmp_path / "model")
    again = PPO.load(tmp_path / "model", env=worlds(heightmap))
    obs = batch(heightmap)
    actions = [m.predict(obs, deterministic=True)[0] for m in (model, again)]
    np.testing.assert_array_equal(*actions)
    again.learn(192, callback=DiscriminatorRewardCallback(discriminator=DISCRIMINATOR))
    model.policy.save(tmp_path / "policy.pt")
    alone = AdaptNetPolicy.load(tmp_path / "policy.pt", device="cpu")
    np.testing.assert_array_equal(alone.predict(obs, deterministic=True)[0], actions[0])


def test_worlds_without_a_companion_have_weights_of_their_own(tiny_base, two_styles):
    """Advantages are each objective's, standardised, times the weights of the world that they are of."""
    model = learner(tiny_base, two_styles)
    callback = DiscriminatorRewardCallback(
        {"imitation": 0.8, "goal": 0.2}, discriminator=DISCRIMINATOR, alone={"imitation": 0.25}
    )
    checked = []

    def check(trained):
        buffer = trained.rollout_buffer
        standard = standardised_advantages(buffer)
        imitation = np.repeat([0.2, 0.8, 0.8], 2)
        expected = imitation * standard[..., 0] + (1 - imitation) * standard[..., 1]
        np.testing.assert_allclose(buffer.advantages, expected, rtol=2e-3, atol=2e-3)
        checked.append(True)

    model.learn(192, callback=[callback, Check(check)])
    assert checked


def test_stock_ppo_learns_beside_companions_without_the_callback(tiny_base, two_styles):
    model = learner(tiny_base, two_styles).learn(192)
    assert any(p.abs().max() > 0 for p in model.policy.actor.adaptations["main"].adaptors.parameters())


def test_the_number_of_companions_must_be_the_worlds(tiny_base, two_styles):
    with pytest.raises(ValueError, match="there are 1 companions, but observations tell 2 apart"):
        learner(tiny_base, two_styles[:1])
    with pytest.raises(ValueError, match="there are 2 companions, but observations tell 0 apart"):
        adapt(AdaptNetPolicy, ToyEnv(), tiny_base, companions=[str(f) for f in two_styles])
    with pytest.raises(ValueError, match="there are 0 companions, but observations tell 2 apart"):
        adapt(AdaptNetPolicy, worlds(), tiny_base)


def test_a_companion_injects_where_all_do(tiny_base, tmp_path):
    files = []
    for name, injection in (("first", "z0"), ("second", "z1")):
        torch.manual_seed(0)
        files.append(save_adaptation(adapt(AdaptNetPolicy, ToyEnv(), tiny_base, injection=injection), tmp_path / name))
    with pytest.raises(ValueError, match="injects into z0, not into 'z1'"):
        learner(tiny_base, files)
