"""Write what the tests replay: ten worlds over 300 steps as the environments compute them.

python web/replay.py FILE
"""

import gzip
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adapt_envs import SUITE, AdaptVectorEnv
from adapt_envs.features import heading_frame_features, heightmaps, observations
from adapt_envs.portable import BODIES, GROUNDS, LOCKS, portable_scene
from adapt_envs.simulation import Worlds
from adapt_envs.tasks import goal_observation
from sb3_adaptnet import load_policy

STEPS, HEIGHTMAP_EVERY = 300, 100
FIRST = np.zeros(1, np.int64)
NAMES = ("qpos", "qvel", "actions", "observations", "heightmaps", "fallen", "goals")
WORLDS = (
    ("walk", "plain", "plain", "flat"), ("walk-stoop", "plain", "plain", "flat"), ("run", "plain", "plain", "flat"),
    ("walk-icewalk", "plain", "plain", "ice"), ("walk-terrainhills", "plain", "plain", "hills"),
    ("walk-jauntyskip", "plain", "plain", "flat"), ("walk-obstacles", "plain", "plain", "blocks"),
    ("run-longshins", "long_shins", "plain", "flat"), ("run-lockedrightknee", "plain", "right_knee", "flat"),
    ("walk", "long_upper_arms", "elbow", "flat"),
)  # fmt: skip
"""Policy, body, lock and ground of each; every part of a scene comes up."""


def main() -> None:
    """Record all worlds into the file that the command line names."""
    worlds = [recorded(*world) for world in WORLDS]
    Path(sys.argv[1]).write_bytes(gzip.compress(json.dumps(worlds).encode(), mtime=0))


def recorded(policy_name: str, body: str, lock: str, ground: str) -> dict[str, Any]:
    """One world of the environments' own, from the site's start state, with a goal that turns."""
    base = policy_name.split("-")[0]
    task = SUITE[base.capitalize()]
    env = AdaptVectorEnv(
        GROUNDS[ground].row, num_threads=1, max_episode_steps=None, heightmap=True, timer_range=task.timer_range,
        morphology=BODIES[body].row.morphology, locked=LOCKS[lock].row.locked,
    )  # fmt: skip
    policy, worlds = load_policy(policy_name, env), env.worlds
    start = portable_scene(body, lock, ground)["starts"][base]
    env.reset(seed=0)
    worlds.physics.set_states(FIRST, np.array([start["qpos"]]), np.array([start["qvel"]]))
    worlds.history[0, 1:] = np.reshape(start["history"], (4, 15, 13))
    rows: dict[str, list[Any]] = {name: [] for name in NAMES}
    for step in range(STEPS + 1):
        env.set_goal(start["heading"] + 0.8 * np.sin(step / 60), float(np.mean(task.speed_range)))
        seen = observed(worlds)
        action = policy.predict(seen, deterministic=True)[0]
        row = (
            worlds.physics.qpos, worlds.physics.qvel, action, short(seen["observation"]),
            short(seen["heightmap"]) if step % HEIGHTMAP_EVERY == 0 else [None], worlds.fallen,
            np.column_stack([worlds.goals.target, worlds.goals.speed]),
        )  # fmt: skip
        for name, values in zip(NAMES, row, strict=True):
            rows[name].append(values[0].tolist() if isinstance(values, np.ndarray) else values[0])
        worlds.step(action, None)
    env.close()
    return {"policy": policy_name, "base": base, "body": body, "lock": lock, "ground": ground, **rows}


def observed(worlds: Worlds) -> dict[str, NDArray[np.float32]]:
    """The present observations of all worlds."""
    features = heading_frame_features(worlds.history, worlds.ground.floor_at(worlds.root_xy))
    place = worlds.root_xy, worlds.root_heading
    goal = goal_observation(*place, worlds.goals.target, worlds.goals.speed)
    return {"observation": observations(features, goal), "heightmap": heightmaps(worlds.ground, *place)}


def short(values: NDArray[np.float32]) -> list[list[float]]:
    """Rows of float32 numbers as the shortest decimals that stand for them."""
    return [[float(str(value)) for value in row.ravel()] for row in values]


if __name__ == "__main__":
    main()
