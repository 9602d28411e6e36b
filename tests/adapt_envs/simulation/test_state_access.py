"""States, goals and references that learners read are those of the worlds; worlds may be restarted one by one."""

import numpy as np
import pytest

from adapt_envs import make_vector


@pytest.fixture
def env():
    env = make_vector("AdaptNet/Humanoid-Stoop-v0", 4, num_threads=1)
    env.reset(seed=0)
    return env


def test_fresh_worlds_stand_in_their_start_states(env):
    reference, states = env.reference_states, env.physics_states
    assert np.allclose(reference.qpos[env.worlds.starts], states.qpos)
    assert np.allclose(reference.qvel[env.worlds.starts], states.qvel)
    assert np.allclose(reference.history[env.worlds.starts], env.link_histories, atol=1e-5)
    assert len(reference.qpos) == env.worlds.reference.num_states
    assert reference.cyclic


def test_what_is_read_is_a_copy(env):
    read = (*env.physics_states, env.link_histories, *env.goal_states)
    before = [part.copy() for part in read]
    env.step(np.zeros(env.action_space.shape, np.float32))
    assert all(np.array_equal(a, b) for a, b in zip(read, before, strict=True))
    assert not np.array_equal(env.physics_states.qpos, before[0])


def test_single_worlds_restart(env):
    env.step(np.zeros(env.action_space.shape, np.float32))
    before, ids = env.physics_states.qpos, np.array([1, 3])
    observations = env.restart(ids)
    assert observations.shape == (2, 784)
    assert np.allclose(env.physics_states.qpos[ids], env.reference_states.qpos[env.worlds.starts[ids]])
    assert np.array_equal(env.physics_states.qpos[[0, 2]], before[[0, 2]])
    assert np.array_equal(env.worlds.steps, [1, 0, 1, 0])


def test_a_world_goes_on_from_another_ones_situation(env):
    """With its links' past and its goal: the same observations come next, up to the solver's warm start."""
    still = np.zeros(env.action_space.shape, np.float32)
    for _ in range(5):
        seen = env.step(still)[0]
    situations, ids = env.situations, np.array([0, 1])
    went = [env.step(still)[0][2:] for _ in range(5)]
    observations = env.restart(ids, situations.of(np.array([2, 3])))
    assert np.allclose(observations, seen[2:], atol=1e-6)
    assert np.array_equal(env.worlds.starts[ids], [-1, -1])
    for name in ("target", "speed", "distance", "steps_left"):
        assert np.array_equal(getattr(env.situations, name)[ids], getattr(situations, name)[2:])
    for expected in went:
        assert np.allclose(env.step(still)[0][:2], expected, atol=1e-3)


def test_gaits_of_a_long_motion_are_cycles_at_the_wanted_speeds():
    env = make_vector("AdaptNet/Humanoid-Walk-v0", 1, num_threads=1)
    gaits = env.reference_gaits([0.6, 1.4, 9.0])
    assert [round(gait.mean_speed, 1) for gait in gaits] == [0.6, 1.4]
    for gait in gaits:
        assert gait.cyclic
        assert 12 <= len(gait.qpos) <= 90
        step = np.linalg.norm(np.diff(gait.qpos[:, 7:], axis=0), axis=1)
        assert np.linalg.norm(gait.qpos[0, 7:] - gait.qpos[-1, 7:]) < 1.5 * step.max()
    with pytest.raises(ValueError, match="no gait cycle at 9.00 m/s"):
        env.reference_gaits([9.0])


def test_with_the_clip_on_the_body_the_reference_takes_the_bodys_own_steps():
    """Longer legs take longer steps in a longer time, as the windows show them."""
    plain, own = (
        make_vector("AdaptNet/Humanoid-LongThighsWalk-v0", 1, num_threads=1, motion="Stoop", clip_on_body=on_body)
        for on_body in (False, True)
    )
    shown, reference = own.worlds.reference.shown, own.reference_states
    assert len(reference.qpos) == shown.period > len(plain.reference_states.qpos)
    assert reference.mean_speed == shown.mean_speed > 1.05 * plain.reference_states.mean_speed
    np.testing.assert_allclose(reference.qpos[:, 7:], shown.qpos[: shown.period, 7:], atol=1e-9)
    moved = np.linalg.norm(reference.qvel[:, :2], axis=1).mean()
    assert moved == pytest.approx(shown.mean_speed, rel=0.02)
    np.testing.assert_allclose(reference.history[:, -1, :, 2], own.worlds.reference.poses[..., 2], atol=1e-5)


def test_gait_cycles_on_the_body_are_its_own_too():
    plain, own = (
        make_vector("AdaptNet/Humanoid-LongThighsWalk-v0", 1, num_threads=1, clip_on_body=on_body)
        for on_body in (False, True)
    )
    assert own.reference_gaits([1.2])[0].mean_speed > 1.05 * plain.reference_gaits([1.2])[0].mean_speed
