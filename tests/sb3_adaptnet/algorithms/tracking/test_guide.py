"""Guides turn at a bounded rate, wait for their characters, and find the phase again."""

import numpy as np
import pytest
import torch

from adapt_envs import make_vector
from sb3_adaptnet.algorithms.tracking.guide import CONTROL_DT, LONGEST_LEAD, TURN_ACCELERATION, Guide
from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.world_model.character import Character


@pytest.fixture
def guide():
    env = make_vector("AdaptNet/Humanoid-GooseStep-v0", 1)
    motion = TrackedMotion.of(Character.of(env.model), torch.device("cpu"), **env.reference_states._asdict())
    guide = Guide(motion, 5)
    guide.fastest_turn = 0.6
    guide.restart(np.arange(5), np.arange(5), motion.facing.numpy()[:5])
    return guide


def test_a_guide_begins_where_its_character_faces(guide):
    assert np.allclose(guide.headings, 0, atol=1e-6)
    assert np.array_equal(guide.phases, np.arange(5))


def test_it_turns_to_the_target_as_fast_as_it_may(guide):
    angles = np.array([0.0, 0.4, 1.5, -1.5, 3.0])
    target, headings = 5 * np.stack([np.cos(angles), np.sin(angles)], axis=1), []
    for _ in range(300):
        guide.advance(target, guide.headings + guide._facing[guide.phases])
        headings.append(guide.headings.copy())
    rates = np.diff(headings, axis=0) / CONTROL_DT
    assert np.abs(rates).max() == pytest.approx(0.6)
    assert np.abs(np.diff(rates, axis=0)).max() <= TURN_ACCELERATION * CONTROL_DT + 1e-9
    assert np.allclose(headings[-1], angles, atol=1e-3)


def test_it_keeps_its_direction_near_the_target(guide):
    guide.advance(np.full((5, 2), 0.1), guide.headings)
    assert np.allclose(guide.headings, 0, atol=1e-6)


def test_it_waits_for_its_character(guide):
    for _ in range(300):
        guide.advance(np.array([[0.0, 5.0]] * 5), guide._facing[guide.phases])
    assert np.allclose(guide.headings, LONGEST_LEAD, atol=0.05)


def test_it_finds_its_phase_again(guide):
    true = guide.motion.wrapped(guide.phases + np.array([0, 1, -2, 2, 5]))
    positions = guide.motion.positions[true]
    assert np.allclose(guide.errors(positions)[0], 0)
    guide.resynchronise(positions)
    assert np.array_equal(guide.phases[:4], true[:4])
    assert abs(guide.phases[4] - true[4]) == 3
