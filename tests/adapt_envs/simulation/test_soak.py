"""A million steps over all environments: nothing leaks, and every world that diverges is reported."""

import gc

import numpy as np
import pytest

from adapt_envs import SUITE, env_id, make_vector

WORLDS, STEPS = 512, 21


def resident_kb():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def run(name, seed):
    """Random actions on 512 worlds; returns (steps, diverged worlds) after checking what comes out."""
    env = make_vector(env_id(name), WORLDS, stagger=True)
    env.reset(seed=seed)
    rng, reported = np.random.default_rng(seed), 0
    for _ in range(STEPS):
        actions = rng.normal(env.single_action_space.mean_pose, 0.3, env.action_space.shape)
        observations, rewards, _, _, infos = env.step(actions.astype(np.float32))
        parts = observations.values() if isinstance(observations, dict) else (observations,)
        assert all(np.isfinite(part).all() for part in parts)
        assert ((rewards >= 0) & (rewards <= 1)).all()
        assert np.isfinite(env.pose_windows).all()
        if infos:
            reported += int((infos["final_info"]["end"] == "diverged").sum())
    assert reported == env.diverged_worlds
    env.close()
    return WORLDS * STEPS, reported


@pytest.mark.slow
def test_a_million_steps_over_all_families():
    total, diverged, memory = 0, {}, []
    for lap in range(3):
        for name in SUITE:
            steps, found = run(name, seed=lap)
            total += steps
            diverged[name] = diverged.get(name, 0) + found
        gc.collect()
        memory.append(resident_kb())
    print(f"{total} steps; diverged worlds: { {name: n for name, n in diverged.items() if n} }; resident {memory} kB")
    assert total > 1e6
    # The first lap fills caches of clips and models; the second and third must not need more.
    assert memory[2] < memory[0] + 50_000
    # A fault made on purpose is reported, so that a count of zero above means something.
    env = make_vector(env_id("TerrainHills"), 4)
    env.reset(seed=0)
    env.worlds.physics.qvel[1, 8] = 1e12
    infos = env.step(np.zeros(env.action_space.shape, np.float32))[4]
    assert infos["final_info"]["end"][1] == "diverged"
    assert env.diverged_worlds == 1
