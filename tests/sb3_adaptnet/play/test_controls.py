"""The loop that plays obeys the controls."""

import math

import numpy as np
import pytest
from evaluation_cases import STOOP, save_tiny_adaptation, save_tiny_base

from sb3_adaptnet.commands.policy_options import open_policy
from sb3_adaptnet.evaluation.recording import open_worlds
from sb3_adaptnet.play.controls import Controls, apply, play, weights_between


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    base = save_tiny_base(tmp_path_factory.mktemp("tiny"))
    return base, save_tiny_adaptation(base, "one", seed=1), save_tiny_adaptation(base, "two", seed=2)


@pytest.fixture
def one_world():
    return open_worlds(STOOP, 1, num_threads=1)


class Notes:
    """A view that writes down where the goal is, and changes a wish at step 5."""

    def __init__(self, env, controls):
        self.env, self.controls, self.goals, self.running = env, controls, [], True

    def show(self):
        goals = self.env.worlds.goals
        offset = goals.target[0] - self.env.worlds.root_xy[0]
        self.goals.append((math.atan2(offset[1], offset[0]), float(goals.speed[0])))
        if len(self.goals) == 5:
            self.controls.heading, self.controls.speed = -2.0, 0.7
        self.running = len(self.goals) < 10

    def close(self):
        self.running = False


def test_the_loop_obeys_until_the_view_is_closed(files, one_world):
    policy = open_policy(str(files[0]), one_world)
    controls = Controls.of(policy, one_world)
    assert controls.alpha is None and controls.weights == {}
    assert controls.speed == pytest.approx(np.mean(one_world.worlds.spec.speed_range))
    notes = Notes(one_world, controls)
    assert play(policy, one_world, notes, controls) == 10
    assert notes.goals[0] == pytest.approx((0.0, np.mean(one_world.worlds.spec.speed_range)), abs=1e-5)
    assert notes.goals[-1] == pytest.approx((-2.0, 0.7), abs=1e-5)


def test_alpha_blend_and_goals_reach_policy_and_worlds(files, one_world):
    policy = open_policy(str(files[1]), one_world, styles={str(files[2]): None})
    one_world.reset(seed=0)
    controls = Controls.of(policy, one_world, "stroll")
    assert controls.labels == {"main": "stroll"}
    assert controls.alpha == 1.0 and controls.weights == {"main": 0.5, "two": 0.5}
    controls.alpha, controls.weights = 0.3, {"main": 0.0, "two": 1.0}
    apply(controls, policy, one_world)
    assert policy.alpha == 0.3 and policy.weights == {"main": 0.0, "two": 1.0}
    assert one_world.worlds.goals.held_heading[0] == 0.0
    controls.random_goals = True
    apply(controls, policy, one_world)
    target = one_world.worlds.goals.target.copy()
    apply(controls, policy, one_world)
    assert np.isnan(one_world.worlds.goals.held_heading[0])
    assert np.array_equal(target, one_world.worlds.goals.target)


def test_weights_glide_from_style_to_style():
    names = ("a", "b", "c")
    assert weights_between(dict.fromkeys(names, 0.0), 0.0) == {"a": 1.0, "b": 0.0, "c": 0.0}
    assert weights_between(dict.fromkeys(names, 0.0), 1.25) == {"a": 0.0, "b": 0.75, "c": 0.25}
    assert weights_between(dict.fromkeys(names, 0.0), 7.0) == {"a": 0.0, "b": 0.0, "c": 1.0}
