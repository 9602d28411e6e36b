"""SVG beside frozen adaptations: each group of worlds follows its own motion, and only what is new learns."""

from functools import partial

import numpy as np
import pytest
import torch
from policy_cases import disturb
from rollout_cases import quiet

from sb3_adaptnet import AdaptVecEnv, save_adaptation
from sb3_adaptnet.algorithms.cost_critic import critic_inputs
from sb3_adaptnet.algorithms.imagination import imagine
from sb3_adaptnet.algorithms.svg import SVG
from sb3_adaptnet.stacking import JoinedWorlds

WALK, STOOP = "AdaptNet/Humanoid-Walk-v0", "AdaptNet/Humanoid-Stoop-v0"
GAITS = {"gaits": [0.9, 1.3]}


@pytest.fixture
def companion(make_svg, tmp_path):
    policy = make_svg().policy
    disturb(policy.actor.adaptations)
    return save_adaptation(policy, tmp_path / "style")


def worlds(**changes):
    groups = (WALK, 3, {}), (STOOP, 2, changes)
    joined = JoinedWorlds([AdaptVecEnv(env, count, num_threads=1, **more) for env, count, more in groups])
    joined.seed(0)
    return joined


@pytest.fixture
def make_beside(make_svg, companion):
    def make(env=None, **choices):
        kwargs = {"companions": [str(companion)], "companion_kl": None}
        settings = {"regression_updates": 0, "guiding": GAITS, **choices}
        return make_svg(env=env or worlds(), policy_kwargs=kwargs, **settings)

    return make


def test_what_is_new_learns_and_companions_stay(make_beside):
    model = make_beside()
    before = {name: tensor.clone() for name, tensor in model.policy.actor.state_dict().items() if "norm" not in name}
    model.learn(80)
    after = model.policy.actor.state_dict()
    changed = {name for name in before if not torch.equal(before[name], after[name])}
    assert changed and all(name.startswith("adaptations.main.") for name in changed)


def test_each_group_follows_its_own_motion(make_beside):
    model = make_beside().learn(40)
    rollout, gaits = model._rollouts.latest(1)[0], model.motion.gaits
    assert rollout.companions.tolist() == [0, 0, 0, 1, 1]
    own = gaits.of(rollout.phases)
    assert own[:, :3].max() < len(gaits.starts) - 1 and (own[:, 3:] == len(gaits.starts) - 1).all()
    stoop = AdaptVecEnv(STOOP, 2, num_threads=1).simulation.reference_states
    assert gaits.lengths[-1] == len(stoop.qpos)
    part = rollout.of(np.array([1, 4]))
    assert part.companions.tolist() == [0, 1] and part.window(0, 4).companions.tolist() == [0, 1]


def test_the_critic_tells_motions_apart_where_all_else_is_alike(make_beside):
    model = make_beside().learn(40)
    part = model._rollouts.latest(1)[0].window(0, 1)
    with torch.no_grad():
        (step,) = imagine(partial(model._mean_action, companions=part.companions), model.world_model.frozen(), part)
    motion, phases = model.motion, step.guided.phases
    stoops = torch.full_like(phases, motion.gaits.starts[-1])
    read = [
        critic_inputs(model.world_model, motion, step.state, step.view, step.guided._replace(phases=now))
        for now in (phases, stoops)
    ]
    joints = len(motion.angles)
    assert torch.equal(read[0][:, -joints:], motion.angles.t()[phases])
    assert (read[1] - read[0])[:3, -joints:].abs().max(dim=1).values.min() > 0.3  # it bends by more than that [rad]


def test_the_imagined_states_are_the_real_ones(make_beside):
    model = make_beside().learn(40)
    with model.weight_average.learning():
        model.collect_rollout(quiet())
        rollout = model._rollouts.latest(1)[0].window(0, 4)
        act = partial(model._mean_action, companions=rollout.companions)
        steps = list(imagine(act, model.world_model.frozen(), rollout))
    alive = torch.as_tensor(rollout.alive)
    for step, imagined in enumerate(steps):
        real = torch.as_tensor(rollout.transitions.qpos[step + 1, :, 7:])
        torch.testing.assert_close(imagined.state.angles.t()[alive[step]], real[alive[step]], atol=1e-4, rtol=0)
    alone = model._mean_action(torch.as_tensor(model._last_obs), np.zeros(5, np.int64))
    beside = model._mean_action(torch.as_tensor(model._last_obs), rollout.companions)
    assert torch.equal(alone[:3], beside[:3]) and not torch.allclose(alone[3:], beside[3:])


def test_a_saved_model_goes_on_beside_its_companions(make_beside, tmp_path):
    model = make_beside().learn(40)
    model.save(tmp_path / "model")
    loaded = SVG.load(tmp_path / "model", env=model.env, device="cpu")
    assert loaded.learn(40, reset_num_timesteps=False).num_timesteps == 80


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"mirror": True}, "mirror is True, but beside companions it must be False"),
        ({"regression_updates": 3}, "regression_updates is 3, but beside companions it must be 0"),
        ({"episodes": {"partial_share": 0.2}}, "partial_share is 0.2, but beside companions it must be 0"),
        ({"world": "new"}, "world_model is 'new', but beside companions it must be one that is there"),
    ],
)
def test_what_is_not_made_for_companions_gets_a_sentence(make_beside, wrong, sentence):
    with pytest.raises(ValueError, match=sentence):
        make_beside(**wrong)


def test_a_companion_with_another_body_gets_a_sentence(make_beside):
    with pytest.raises(ValueError, match="companions that change no body"):
        make_beside(worlds(morphology="long_thighs"))
