"""Pushes: their impulse, their times and their directions."""

import mujoco
import numpy as np
import pytest

from adapt_envs import AdaptEnv, TaskSpec, env_id, make_vector
from adapt_envs.drawing.world_view import SceneRenderer
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.tasks.push import Pushes, PushSchedule

SECOND = 30


def test_a_push_gives_its_impulse_to_the_whole_character():
    """High above the ground nothing else changes the horizontal momentum: 1000 N x 0.2 s = 200 N s, 4.1 m/s."""
    env = make_vector(env_id("PushWalk"), 8)
    env.reset(seed=0)
    worlds, worlds_all = env.worlds, np.arange(8)
    qpos, qvel = worlds.physics.qpos.copy(), worlds.physics.qvel.copy()
    qpos[:, 2] += 50
    worlds.physics.set_states(worlds_all, qpos, qvel)
    mass = worlds.model.body_mass.sum()
    pose = np.tile(env.single_action_space.mean_pose, (8, 1))

    def momentum():
        return mass * centre_velocity(worlds)

    worlds.pushes._until_next[:] = 2
    before, direction, seen = momentum(), np.zeros((8, 3)), 0
    for _ in range(12):
        worlds.step(pose, None)
        acting = worlds.pushes.force.any(axis=1)
        seen += acting
        direction[acting] = worlds.pushes.force[acting] / 1000
    change = momentum() - before
    assert (seen == 6).all()
    assert np.allclose(np.linalg.norm(direction, axis=1), 1)
    # The implicit integrator keeps momentum to a percent.
    assert np.allclose(change[:, :2], 200 * direction[:, :2], atol=2)


def centre_velocity(worlds):
    """(N, 3) velocity of the characters' centres of mass."""
    out, data = [], mujoco.MjData(worlds.model)
    for world in range(worlds.physics.num_worlds):
        worlds.physics.mujoco_data(world, data)
        mujoco.mj_subtreeVel(worlds.model, data)
        out.append(data.subtree_linvel[1].copy())
    return np.array(out)


def test_pushes_come_every_three_to_six_seconds_from_everywhere():
    pushes, rng, n = Pushes(PushSchedule(), 400), np.random.default_rng(0), 400
    pushes.restart(np.arange(n), rng)
    forces = np.stack([pushes.step(rng).copy() for _ in range(20 * SECOND)])
    acting = forces.any(axis=2)
    starts = acting & ~np.concatenate([np.zeros((1, n), bool), acting[:-1]])
    for world in range(n):
        times = np.flatnonzero(starts[:, world]) * CONTROL_DT
        assert 3 - 1e-9 <= times[0] <= 6 + 1e-9
        assert ((np.diff(times) > 3 - 1e-9) & (np.diff(times) < 6 + 1e-9)).all()
    assert acting.sum() / starts.sum() == pytest.approx(6, abs=0.1)
    assert (forces[..., 2] == 0).all()
    sampled = forces[starts]
    assert np.allclose(np.linalg.norm(sampled, axis=1), 1000)
    assert np.abs(sampled.mean(axis=0)[:2]).max() < 80  # all directions alike: the mean of 1,700 is near zero
    assert np.linalg.norm(np.unique(sampled, axis=0), axis=1).size > 1000


def test_the_scale_grows_the_force_and_a_reset_ends_a_push():
    env = make_vector(env_id("PushRun"), 4)
    env.reset(seed=0)
    env.push_scale = 0.5
    assert (env.push_scale == 0.5).all() and env.push_scale.shape == (4,)
    env.worlds.pushes._until_next[:] = 0
    pose = np.tile(env.single_action_space.mean_pose, (4, 1))
    env.step(pose)
    assert np.allclose(np.linalg.norm(env.worlds.pushes.force, axis=1), 500)
    env.push_scale = [0, 0.25, 0.5, 1]
    env.worlds.pushes._until_next[:] = 0
    env.step(pose)
    assert np.allclose(np.linalg.norm(env.worlds.pushes.force, axis=1), [0, 250, 500, 1000])
    env.push_scale = 0.5
    env.worlds.pushes._until_next[:] = 0
    env.step(pose)
    env.worlds.reset(np.array([1]))
    assert not env.worlds.pushes.force[1].any()
    assert env.worlds.pushes.force[[0, 2, 3]].any(axis=1).all()
    with pytest.raises(ValueError, match="-1"):
        env.push_scale = -1
    with pytest.raises(ValueError, match="inf"):
        env.push_scale = [0, 0, 0, np.inf]
    for wrong in ([0.5, 0.5], "half"):
        with pytest.raises(ValueError, match=r"push_scale is .*expected a number, or 4 of them, one for each world"):
            env.push_scale = wrong
    with pytest.raises(ValueError, match=r"goal_spread is \[1, 1\], expected a number, or 4 of them"):
        env.goal_spread = [1, 1]
    plain = make_vector(env_id("Walk"), 1)
    assert plain.push_scale == 1
    with pytest.raises(ValueError, match="no pushes"):
        plain.push_scale = 0.5


def test_a_wrong_schedule_is_named():
    with pytest.raises(ValueError, match=r"seconds is 4.*interval \(3, 6\)"):
        PushSchedule(seconds=4, interval=(3, 6))


def test_pushes_follow_the_seed():
    def forces(seed):
        env = AdaptEnv("PushWalk")
        env.reset(seed=seed)
        env.worlds.pushes._until_next[:] = 0
        env.step(env.action_space.mean_pose)
        return env.worlds.pushes.force.copy()

    assert np.array_equal(forces(1), forces(1))
    assert not np.array_equal(forces(1), forces(2))


def test_the_arrow_is_sampled_only_while_a_push_acts():
    env = AdaptEnv(TaskSpec("Stoop", push=PushSchedule()))
    env.reset(seed=0)
    renderer = SceneRenderer(env.worlds, (160, 160))
    env.step(env.action_space.mean_pose)
    counts = []
    for force in (0, -1000, 0):
        env.worlds.pushes.force[0, 1] = force
        picture = renderer.picture().astype(int)
        counts.append(int((picture[..., 0] - picture[..., 1] > 90).sum()))
    renderer.close()
    assert counts[1] > counts[0] + 20
    assert abs(counts[2] - counts[0]) < 5
