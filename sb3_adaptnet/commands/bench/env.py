"""`adaptnet bench env`: what a step of the worlds costs, against the bare physics and other ways to run it."""

import argparse
import json
import multiprocessing
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium as gym
import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecEnv
from tqdm import tqdm

from adapt_envs.commands.doctor import processor, usable_cores
from adapt_envs.commands.numbers import positive, seed_of
from adapt_envs.features.heightmap import heightmaps
from adapt_envs.model.humanoid import PHYSICS_STEPS
from adapt_envs.registration import env_id, make_vector
from adapt_envs.vector_env import AdaptVectorEnv

_NOISE = 0.05
"""Standard deviation of the noise on actions, which are in [-1, 1]."""
_STEPS, _ROUNDS = 20, 5
"""Steps of a round, and rounds that a median is taken over."""
_SB3_WORLDS = 64
"""Worlds of what this is compared with."""
_SIZES = (64, 256, 512, 1024, 2048, 4096)
"""Numbers of worlds that the cost of a step is measured for."""
_GYM_SUBSTEPS = 5
"""Physics steps per step of Gymnasium's Humanoid-v5 (frame_skip)."""
_PRELOADED = ["adapt_envs", "sb3_adaptnet.commands.main", "gymnasium.envs.mujoco.humanoid_v5"]
"""Imported once, by the server that the 64 processes are forked from: one import each took over two minutes."""


def add_parser(subparsers: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the subcommand `env`."""
    parser = subparsers.add_parser("env", help="steps per second of the worlds, and ratios measured in the same run")
    parser.add_argument("--id", default=env_id("Walk"), help="environment to measure (default: %(default)s)")
    parser.add_argument("--worlds", type=positive, default=512)
    parser.add_argument("--threads", type=positive, default=usable_cores())
    parser.add_argument("--seed", type=seed_of, default=0)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Measure and print."""
    figures = measure(arguments.id, arguments.worlds, arguments.threads, arguments.seed)
    if arguments.json:
        print(json.dumps(figures))
        return 0
    rows = figures.pop("cost_by_worlds")
    for name, value in figures.items():
        print(f"{name:36s}{value:.3f}" if isinstance(value, float) else f"{name:36s}{value}")
    for row in rows:
        print("{worlds:6d} worlds: {us_per_world_step:.1f} us a world step".format(**row))
    return 0


def measure(environment: str, worlds: int, threads: int, seed: int) -> dict[str, Any]:
    """All figures: rates are world steps (1/30 s) per second, ratios the median over rounds taken in turn.

    Args:
        environment: id of the suite.
        worlds: worlds of the main measurement.
        threads: threads of the physics.
        seed: seed of states and noise.
    """
    multiprocessing.set_forkserver_preload(_PRELOADED)
    bar = tqdm(total=6 + len(_SIZES), desc="bench env", disable=None)
    memory = _kib_per_world(environment, threads, seed)
    bar.update()
    env = make_vector(environment, worlds, num_threads=threads)
    env.reset(seed=seed)
    actions = _actions(env, seed)
    rate, physics = _in_turn(lambda: _timed(env.step, actions, worlds), _physics_timer(env, threads, actions, worlds))
    bar.update()
    figures: dict[str, Any] = {
        "environment": environment, "worlds": worlds, "threads": threads, "seed": seed, "cpu": processor(),
        "steps_per_second": float(np.median(rate)), "physics_steps_per_second": float(np.median(physics)),
        "ratio_to_physics": float(np.median(rate / physics)), "kib_per_world": memory,
    }  # fmt: skip
    for name, rival in (
        ("dummy_vec_env", partial(_sb3_timer, DummyVecEnv, environment, seed)),
        ("subproc_vec_env", partial(_sb3_timer, partial(SubprocVecEnv, start_method="forkserver"), environment, seed)),
        ("gymnasium_humanoid", partial(_gymnasium_timer, seed)),
    ):
        figures[f"ratio_to_{name}"] = _against(rival, env, actions, worlds)
        bar.update()
    figures |= _heightmap_cost(worlds, threads, seed)
    bar.update()
    figures["cost_by_worlds"] = _scaling(environment, threads, seed, bar)
    bar.close()
    return figures


def _actions(env: AdaptVectorEnv, seed: int) -> NDArray[np.float32]:
    """Clip poses with noise of 0.05: (steps, N, J)."""
    rng = np.random.default_rng(seed)
    reference, count = env.worlds.reference, _STEPS
    poses = reference.pose_actions(rng.integers(reference.num_states, size=count * env.num_envs))
    noise = _NOISE * rng.standard_normal((count * env.num_envs, poses.shape[1]))
    return np.clip(poses + noise, -1, 1).astype(np.float32).reshape(count, env.num_envs, -1)


def _timed(step: Callable[[NDArray[np.float32]], object], actions: NDArray[np.float32], worlds: int) -> float:
    """World steps per second of `step` over all `actions`."""
    start = time.perf_counter()
    for action in actions:
        step(action)
    return len(actions) * worlds / (time.perf_counter() - start)


def _in_turn(*timers: Callable[[], float]) -> list[NDArray[np.float64]]:
    """Rates of several timers, measured in turn after a warm-up so that drift of the machine hits all alike."""
    for timer in timers:
        timer()
    rounds = [[timer() for timer in timers] for _ in range(_ROUNDS)]
    return list(np.array(rounds).T)


def _physics_timer(env: AdaptVectorEnv, threads: int, actions: NDArray[np.float32], worlds: int) -> Callable[[], float]:
    """Bare `mujoco.batch` over the states the environment is in when a round begins."""
    batch = Batch(env.worlds.model, nsim=worlds, nthread=threads)
    stage = int(mujoco.mjtStage.mjSTAGE_VEL)

    def step(action: NDArray[np.float32]) -> None:
        batch.ctrl[:] = action
        batch.step(nstep=PHYSICS_STEPS, stage=stage)

    def timer() -> float:
        batch.qpos[:], batch.qvel[:] = env.worlds.physics.qpos, env.worlds.physics.qvel
        return _timed(step, actions, worlds)

    return timer


def _against(
    rival: Callable[[], tuple[Callable[[], float], Callable[[], None]]],
    env: AdaptVectorEnv, actions: NDArray[np.float32], worlds: int,
) -> float:  # fmt: skip
    timer, close = rival()
    try:
        ours, theirs = _in_turn(lambda: _timed(env.step, actions, worlds), timer)
    finally:
        close()
    return float(np.median(ours / theirs))


def _sb3_timer(
    kind: Callable[[list[Callable[[], gym.Env]]], VecEnv], environment: str, seed: int
) -> tuple[Callable[[], float], Callable[[], None]]:
    """The same single environment 64 times in one of SB3's vector envs."""
    vec = kind([partial(gym.make, environment) for _ in range(_SB3_WORLDS)])
    vec.seed(seed)
    vec.reset()
    low = make_vector(environment, _SB3_WORLDS)
    actions = _actions(low, seed)[: _STEPS // 2]
    return lambda: _timed(vec.step, actions, _SB3_WORLDS), vec.close


def _gymnasium_timer(seed: int) -> tuple[Callable[[], float], Callable[[], None]]:
    """Gymnasium's Humanoid-v5 in AsyncVectorEnv, its rate rescaled to our physics steps per step."""
    vec = gym.make_vec(
        "Humanoid-v5", num_envs=_SB3_WORLDS, vectorization_mode="async", vector_kwargs={"context": "forkserver"}
    )
    vec.reset(seed=seed)
    rng = np.random.default_rng(seed)
    actions = rng.uniform(-0.4, 0.4, (_STEPS, _SB3_WORLDS, 17)).astype(np.float32)
    return lambda: _timed(vec.step, actions, _SB3_WORLDS) * _GYM_SUBSTEPS / PHYSICS_STEPS, vec.close


def _heightmap_cost(worlds: int, threads: int, seed: int) -> dict[str, float]:
    """What looking up the heights around all worlds costs: per world [us], and as a share of a whole step."""
    env = make_vector(env_id("TerrainHills"), worlds, num_threads=threads)
    env.reset(seed=seed)
    actions = _actions(env, seed)
    step, look_up = _in_turn(
        lambda: _timed(env.step, actions, worlds),
        lambda: _timed(
            lambda _: heightmaps(env.worlds.ground, env.worlds.root_xy, env.worlds.root_heading), actions, worlds
        ),
    )
    env.close()
    return {
        "heightmap_us_per_world": 1e6 / float(np.median(look_up)),
        "heightmap_share": float(np.median(step / look_up)),
    }


def _scaling(environment: str, threads: int, seed: int, bar: "tqdm[Any]") -> list[dict[str, float]]:
    """Cost of a world step [us] from 64 to 4096 worlds."""
    rows = []
    for size in _SIZES:
        env = make_vector(environment, size, num_threads=threads)
        env.reset(seed=seed)
        actions = _actions(env, seed)
        _timed(env.step, actions[:4], size)
        rates = [_timed(env.step, actions, size) for _ in range(3)]
        rows.append({"worlds": size, "us_per_world_step": 1e6 / float(np.median(rates))})
        env.close()
        bar.update()
    return rows


def _kib_per_world(environment: str, threads: int, seed: int) -> float:
    """Memory of a world [KiB] among 4096, what they share included; before anything else has left memory to reuse."""
    before = _resident_kib()
    env = make_vector(environment, _SIZES[-1], num_threads=threads)
    env.reset(seed=seed)
    env.step(np.zeros((_SIZES[-1], env.worlds.model.nu), np.float32))
    found = (_resident_kib() - before) / _SIZES[-1]
    env.close()
    return found


def _resident_kib() -> float:
    """Resident memory of this process [KiB]; 0 where the system does not tell."""
    try:
        with open("/proc/self/status", encoding="ascii") as status:
            return next(float(line.split()[1]) for line in status if line.startswith("VmRSS"))
    except (OSError, StopIteration):
        return 0.0
