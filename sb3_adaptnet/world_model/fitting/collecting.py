"""Recording transitions of any policy in any of our batched environments."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sb3_adaptnet.world_model.fitting.babble import Babble
from sb3_adaptnet.world_model.transitions import Transitions

Act = Callable[[Any], NDArray[np.floating]]
"""Observations of N worlds -> actions (N, J)."""


def collect(
    env: Any,
    act: Act,
    steps: int,
    rng: np.random.Generator,
    progress: Callable[[range], Any] = iter,
) -> Transitions:
    """Record `steps` control steps of all worlds, with disturbed actions.

    Args:
        env: an `AdaptVectorEnv`, or what has its `physics_states` and action space; it is reset.
        act: the policy.
        steps: control steps.
        rng: source of the disturbances and of the environment's seed.
        progress: wraps the steps, to show how far it is.

    Returns:
        What happened; every episode's last state is lost to the next one's first.
    """
    space = env.single_action_space
    babble, rest = Babble(space.joint_names, env.num_envs, rng), space.mean_pose
    observations, _ = env.reset(seed=int(rng.integers(2**31)))
    states, chosen, ended = [_single(env)], [], []
    for _ in progress(range(steps)):
        actions = babble.disturbed(act(observations), rest)
        observations, _, terminated, truncated, _ = env.step(actions)
        ends = terminated | truncated
        babble.restart(np.flatnonzero(ends))
        states.append(_single(env))
        chosen.append(actions)
        ended.append(ends)
    qpos, qvel = (np.stack(part) for part in zip(*states, strict=True))
    return Transitions(qpos, qvel, np.stack(chosen), np.stack(ended))


def _single(env: Any) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Positions and velocities now, in single precision: minutes of them have to be kept."""
    states = env.physics_states
    return states.qpos.astype(np.float32), states.qvel.astype(np.float32)
