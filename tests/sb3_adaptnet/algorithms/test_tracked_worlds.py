"""Which errors end an episode, which ends are failures, and what follows the samples."""

import numpy as np
import pytest
import torch

from sb3_adaptnet import AdaptVecEnv
from sb3_adaptnet.algorithms.svg_settings import Episodes
from sb3_adaptnet.algorithms.tracked_worlds import TrackedWorlds
from sb3_adaptnet.algorithms.tracking.guide import Guiding
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.character import Character

WORLDS = 20


@pytest.fixture
def make_worlds():
    def make(guiding=None, **episodes):
        env = AdaptVecEnv("AdaptNet/Humanoid-GooseStep-v0", num_envs=WORLDS, num_threads=1, seed=0)
        character, reference = Character.of(env.simulation.model), env.simulation.reference_states
        motion = TrackedMotion.of(character, torch.device("cpu"), [reference])
        worlds = TrackedWorlds(env, motion, Episodes(**episodes), guiding or Guiding(), np.random.default_rng(0))
        worlds.begin(0)
        return worlds

    return make


def steps(worlds, count):
    """Limp characters: they soon sink and fall."""
    return [worlds.step(np.zeros((WORLDS, 28), np.float32)) for _ in range(count)]


def test_loose_worlds_end_later(make_worlds):
    worlds = make_worlds(error_limit=0.05, loose_limit=9.0, loose_share=0.5)
    assert worlds.loose.tolist() == [True] * 10 + [False] * 10
    worlds.env.set_attr("goal_spread", 0.0)
    worlds.guide.least_style = 1.0  # nobody counts as turning
    for step in steps(worlds, 12):
        off = step.errors > 0.05
        assert np.array_equal(step.ended[10:], (step.dones | off)[10:])
        assert np.array_equal(step.failed & ~step.dones, off & ~worlds.loose & ~step.dones)
        assert np.array_equal(step.ended[:10], step.dones[:10])


def test_a_fall_is_a_failure_and_a_limit_of_steps_is_none(make_worlds):
    worlds = make_worlds(error_limit=9.0, loose_limit=9.0, steps=(2, 2), loose_share=0.5)
    fallen = 0
    for step in steps(worlds, 60):
        for world in np.flatnonzero(step.dones):
            assert step.failed[world] == (step.infos[world]["end"] == "fall")
            fallen += step.failed[world]
        assert not (step.failed & ~step.dones).any()
    assert fallen > 0
    assert (step.ended & ~step.failed).any()


def test_who_gets_lost_has_failed(make_worlds):
    worlds = make_worlds(error_limit=9.0, loose_limit=9.0)
    now, some = worlds.env.simulation.situations, np.arange(3)
    away = now._replace(target=now.target + 100, distance=np.ones_like(now.distance))
    worlds.env.restart(some, away.of(some))
    (step,) = steps(worlds, 1)
    assert [info.get("end") for info in step.infos[:3]] == ["lost"] * 3
    assert step.failed.tolist() == [True] * 3 + [False] * (WORLDS - 3)


def test_the_tight_limit_waits_until_a_world_is_calm(make_worlds):
    worlds = make_worlds(error_limit=0.1, loose_limit=0.4, calm_seconds=1.5, loose_share=0)
    worlds.guide.calm_steps[:] = np.arange(WORLDS) + 30
    assert np.allclose(worlds._error_limits(), [0.4] * 15 + [0.1] * 5)


def test_schedules_follow_the_samples(make_worlds):
    guiding = Guiding(turn_rate={0: 0.2, 100: 9.0}, least_style={0: 1.0, 100: 0.2})
    limits = {"error_limit": {0: 0.3, 100: 0.1}, "loose_limit": {0: 0.5, 100: 1.0}}
    worlds = make_worlds(guiding, **limits, goal_spread={0: 0.0, 100: 1.0}, loose_share={100: 0})
    assert np.all(worlds.guide.fastest_turn == 0.2)
    assert (worlds.guide.least_style, worlds.error_limit) == (1.0, 0.3)
    worlds.schedule(100)
    assert worlds.guide.fastest_turn == pytest.approx(
        np.full(WORLDS, 0.8 * 2 / 2.2)
    )  # a stride of the clip takes 2.2 s
    assert worlds.guide.least_style == pytest.approx(0.2)
    assert (worlds.error_limit, worlds.loose_limit) == (pytest.approx(0.1), pytest.approx(1.0))
    worlds.schedule(50)
    assert worlds.env.vector_env.unwrapped.goal_spread == pytest.approx(0.5)


def test_in_part_no_error_ends_an_episode_and_guides_begin_anew(make_worlds):
    share = {0: 0.0, 1: 0.5}
    limits = {"error_limit": 0.0, "loose_limit": 0.0}
    worlds = make_worlds(**limits, partial_share=share, steps=(90, 90), loose_steps=(90, 90))
    assert (worlds.strengths == 1).all()
    observations = worlds.env.reset()
    worlds.guide.phases[:] = 0
    worlds.guide.turn_rates[:] = 1.0
    worlds.schedule(1)
    in_part = worlds.strengths < 1
    assert in_part.any() and not in_part.all()
    worlds.resynchronise(observations)
    nearest = worlds.guide.motion.nearest(worlds.guide.motion.seen_in(observations))
    assert np.array_equal(worlds.guide.phases[in_part], nearest[in_part])
    assert np.array_equal(worlds.guide.turn_rates == 0, in_part)
    assert not worlds.guide.calm_steps[in_part].any()
    for step in steps(worlds, 15):
        assert np.array_equal(step.ended, step.dones | ~in_part)
    worlds.guide.turn_rates[:] = 1.0
    worlds.schedule(1)  # the same strengths go on
    worlds.resynchronise(step.observations)
    assert worlds.guide.turn_rates.all()


def situated(worlds):
    """(N, 37) where the characters are and where they shall go."""
    situations = worlds.env.simulation.situations
    return np.concatenate([situations.qpos, situations.target], axis=1)


def test_loose_worlds_try_again_what_came_before_they_failed(make_worlds):
    limits = {"error_limit": 0.05, "loose_limit": 0.05, "loose_share": 0.5}
    worlds = make_worlds(**limits, retry_share=1.0)
    worlds.guide.least_style = 1.0
    past, again, others = [], 0, 0
    for _ in range(40):
        past.extend(situated(worlds)[:10])
        step = worlds.step(np.zeros((WORLDS, 28), np.float32))
        now = situated(worlds)
        for world in np.flatnonzero(step.ended & ~step.dones):
            known = any(np.array_equal(now[world], before) for before in past)
            again += known and worlds.loose[world]
            others += known and not worlds.loose[world]
    assert again > 5
    assert others == 0
    assert step.observations.shape == (WORLDS, 784)


def test_who_fell_tries_again_too(make_worlds):
    worlds = make_worlds(error_limit=9.0, loose_limit=9.0, loose_share=1.0, retry_share=1.0)
    past, again = [], 0
    for _ in range(60):
        past.extend(situated(worlds))
        step = worlds.step(np.zeros((WORLDS, 28), np.float32))
        now = situated(worlds)
        fallen = np.flatnonzero(step.dones)
        tried = [any(np.array_equal(now[world], before) for before in past) for world in fallen]
        assert tried == worlds.retries.trying[fallen].tolist()
        again += sum(tried)
    assert again > 5


def test_only_what_fails_at_the_whole_strength_is_tried_again_and_at_that(make_worlds):
    limits = {"error_limit": 9.0, "loose_limit": 9.0, "loose_share": 1.0, "retry_share": 0.5}
    worlds = make_worlds(**limits, partial_share={0: 0.0, 1: 1.0})
    worlds.schedule(1)
    assert (worlds.strengths < 1).all()
    assert sum(step.failed.sum() for step in steps(worlds, 60)) > 5
    assert len(worlds.retries) == 0
    worlds.schedule(0)
    steps(worlds, 60)
    trying = worlds.retries.trying
    assert trying.any() and not trying.all()
    worlds.schedule(1)
    assert np.array_equal(worlds.strengths == 1, trying)


def test_nothing_is_tried_again_without_a_share(make_worlds):
    worlds = make_worlds(error_limit=0.05, loose_limit=0.05)
    steps(worlds, 20)
    assert len(worlds.retries) == 0
