"""Rollouts in a mirror are as good as real ones, where motion and character are symmetric."""

import numpy as np
import pytest
import torch
from rollout_cases import quiet

from sb3_adaptnet import AdaptVecEnv
from sb3_adaptnet.algorithms.imagination import imagine
from sb3_adaptnet.algorithms.rollouts.reflection import Reflection, straight_behind
from sb3_adaptnet.algorithms.svg_loss import asymmetry, state_costs
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.state import State

WORLDS = 6
HALF = np.arange(WORLDS) < WORLDS // 2


@pytest.fixture
def svg(make_svg):
    model = make_svg(WORLDS, "AdaptNet/Humanoid-GooseStep-v0", episodes={"steps": (3, 9), "goal_spread": 1.0})
    model.learn(48)
    model.collect_rollout(quiet())
    return model


@pytest.fixture
def reflection(svg):
    return Reflection.of(svg.world_model.character, svg.motion)


@pytest.mark.parametrize(
    ("env_id", "found"), [("GooseStep", True), ("Stomp", True), ("Limp", False), ("Swaggering", False)]
)
def test_symmetric_motions_are_found(env_id, found):
    simulation = AdaptVecEnv(f"AdaptNet/Humanoid-{env_id}-v0", num_envs=1, num_threads=1).simulation
    character = Character.of(simulation.model)
    motion = TrackedMotion.of(character, torch.device("cpu"), [simulation.reference_states])
    assert (Reflection.of(character, motion) is not None) == found


def test_other_worlds_stay_as_they_were(svg, reflection):
    real = svg._rollouts.latest(1)[0]
    image = reflection.of_rollout(real, HALF, 0.0)
    for name in ("noise", "frames", "targets", "speeds", "phases", "headings", "turn_rates", "style", "failed"):
        assert np.array_equal(getattr(image, name)[:, ~HALF], getattr(real, name)[:, ~HALF])
    for name in ("qpos", "qvel", "actions"):
        here, there = getattr(image.transitions, name), getattr(real.transitions, name)
        assert np.array_equal(here[:, ~HALF], there[:, ~HALF])
        assert not np.array_equal(here[:, HALF], there[:, HALF])


def test_what_happened_costs_as_much_in_the_mirror(svg, reflection):
    real = svg._rollouts.latest(1)[0]
    image, weights = reflection.of_rollout(real, HALF, 0.0), svg.loss_weights.at(0)
    for step in range(len(real)):
        here, there = (costs(svg, rollout, step, weights) for rollout in (real, image))
        for name in here:
            assert torch.allclose(here[name], there[name], atol=1e-4), name


def costs(svg, rollout, step, weights):
    data, model = rollout.transitions, svg.world_model
    state = State.from_mujoco(torch.as_tensor(data.qpos[step + 1]), torch.as_tensor(data.qvel[step + 1]))
    guided = rollout.guided(step, ~data.ended[step], data.ended[step], torch.device("cpu"))
    return state_costs(state, model.view(model.kinematics(state)), svg.motion, guided, weights)


def test_who_does_in_the_mirror_the_mirror_image_is_symmetric(svg, reflection):
    image = reflection.of_rollout(svg._rollouts.latest(1)[0], HALF, 0.0)
    assert np.array_equal(image.mirrored, HALF)
    done = torch.as_tensor(image.transitions.actions[2] - image.noise[2])
    for change, wanted in ((0.0, 0.0), (0.1, done.shape[1] * 0.01)):
        (step,) = imagine(lambda _, change=change: done + change, svg.world_model.frozen(), image.window(2, 1))
        assert np.allclose(asymmetry(step), wanted * HALF, atol=1e-6)


def test_it_can_be_learned(make_svg):
    choices = {"mirror": True, "loss_weights": {"symmetry": 100.0}, "learning_rate": 1e-3}
    svg = make_svg(WORLDS, "AdaptNet/Humanoid-GooseStep-v0", **choices)
    svg.learn(48)
    svg.collect_rollout(quiet())
    frozen, weights, symmetry = svg.world_model.frozen(), svg.loss_weights.at(0), []
    for number in range(60):
        rollout = svg._rollouts.latest(1)[number % 2]
        symmetry.append(svg._improve(frozen, rollout, weights, None)["symmetry"])
    assert symmetry[0] > 0
    assert np.mean(symmetry[-8:]) < 0.75 * np.mean(symmetry[:8])


def test_what_happened_in_the_mirror_can_be_imagined(svg, reflection):
    """With the residuals of each step the imagined states are the real ones, if the policy does what was done."""
    image = reflection.of_rollout(svg._rollouts.latest(1)[0], HALF, 0.0)
    data, alive = image.transitions, image.window(1, 5).alive
    done = iter(data.actions[1:6] - image.noise[1:6])
    steps = imagine(lambda _: torch.as_tensor(next(done)), svg.world_model.frozen(), image.window(1, 5))
    for number, step in enumerate(steps, start=2):
        real = State.from_mujoco(torch.as_tensor(data.qpos[number]), torch.as_tensor(data.qvel[number]))
        on = torch.as_tensor(alive[number - 2])
        assert on.any()
        assert torch.allclose(step.state.angles[:, on], real.angles[:, on], atol=2e-4)
        assert torch.allclose(step.state.position[:, on], real.position[:, on], atol=2e-4)


def test_targets_straight_behind_are_left_out(svg, reflection):
    real = svg._rollouts.latest(1)[0]
    behind = straight_behind(real, 2.5)
    assert behind.any()
    assert not behind.all()
    assert not straight_behind(real, 0.0).any()
    image = reflection.of_rollout(real, HALF, 2.5)
    assert np.array_equal(image.transitions.ended, real.transitions.ended | (behind & HALF))
    assert np.array_equal(image.failed, real.failed)
