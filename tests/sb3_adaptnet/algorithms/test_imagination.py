"""Along a real rollout, an unchanged policy imagines what happened; changed, it gets slopes from the model."""

import numpy as np
import pytest
import torch
from rollout_cases import quiet

from adapt_envs.tasks.goal import goal_observation
from sb3_adaptnet.algorithms.imagination import goal_features, imagine
from sb3_adaptnet.world_model.links import HeadingView
from sb3_adaptnet.world_model.state import State


@pytest.fixture
def svg(make_svg):
    model = make_svg(episodes={"steps": (3, 9)})
    model.learn(48)
    return model


def test_an_unchanged_policy_imagines_the_real_rollout(svg):
    svg.collect_rollout(quiet())
    rollout = svg._rollouts.latest(1)[0]
    steps = list(imagine(svg._mean_action, svg.world_model.frozen(), rollout.window(2, 6)))
    data, alive = rollout.transitions, rollout.window(2, 6).alive
    assert alive[0].any()
    assert not alive.all()
    for number, step in enumerate(steps, start=1):
        real = State.from_mujoco(torch.as_tensor(data.qpos[2 + number]), torch.as_tensor(data.qvel[2 + number]))
        on = torch.as_tensor(alive[number - 1])
        assert torch.equal(step.guided.weights, on.float())
        for imagined, happened in zip(step.state, real, strict=True):
            sign = torch.where((imagined * happened).sum(0) < 0, -1.0, 1.0) if len(imagined) == 4 else 1.0
            assert torch.allclose((sign * imagined)[:, on], happened[:, on], atol=2e-4)


def test_the_first_step_sees_what_the_policy_saw(svg):
    observations = svg._last_obs.copy()
    seen = []
    svg.collect_rollout(quiet())

    def mean_action(observation):
        seen.append(observation)
        return svg._mean_action(observation)

    next(imagine(mean_action, svg.world_model.frozen(), svg._rollouts.latest(1)[0]))
    assert torch.allclose(seen[0], torch.as_tensor(observations), atol=1e-4)


def test_gradients_reach_the_policy_from_the_last_step(svg):
    steps = list(imagine(svg._mean_action, svg.world_model.frozen(), svg._rollouts.latest(1)[0].window(0, 4)))
    weights = [p for p in svg.policy.actor.parameters() if p.requires_grad]
    grads = torch.autograd.grad(steps[-1].state.angles.square().mean(), weights, allow_unused=True)
    assert any(grad is not None and bool(grad.abs().max() > 0) for grad in grads)
    assert all(grad is None or bool(grad.isfinite().all()) for grad in grads)


def test_goals_are_seen_as_the_environments_see_them():
    rng = np.random.default_rng(0)
    xy, heading = rng.normal(size=(9, 2)), rng.uniform(-3, 3, 9)
    target, speed = xy + rng.normal(size=(9, 2)) * 3, rng.uniform(1, 2, 9)
    target[0] = xy[0]
    view = HeadingView(torch.empty(13, 15, 9), torch.tensor(np.cos(heading)), torch.tensor(np.sin(heading)))
    position = torch.tensor(np.column_stack([xy, np.ones(9)]).T)
    found = goal_features(view, position, torch.tensor(target), torch.tensor(speed))
    assert np.allclose(found.numpy(), goal_observation(xy, heading, target, speed), atol=1e-5)
