"""An adaptation and its base in the same world from the same start, drawn beneath each other as time goes on."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from adapt_envs import AdaptVectorEnv
from adapt_envs.drawing.picture import Image, tiled, write_png
from adapt_envs.drawing.scene import Camera
from adapt_envs.drawing.world_view import HIGH, SceneRenderer
from adapt_envs.model.humanoid import CONTROL_DT
from sb3_adaptnet.evaluation.pictures import captioned
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy

SECONDS, COLUMNS = 6.0, 7
_TILE = (270, 300)
_CAMERA = Camera(azimuth=120, elevation=-14, distance=5.6, fovy=28)


class FirstEnds(NamedTuple):
    """How each world's first episode ended.

    Attributes:
        steps: (N,) steps made before the one it ended in; all of them where it went on.
        reasons: (N,) `info["end"]`, such as "fall"; "" where it went on.
    """

    steps: NDArray[np.int64]
    reasons: NDArray[np.str_]


def first_ends(policy: AdaptNetPolicy, env: AdaptVectorEnv, seed: int, steps: int) -> FirstEnds:
    """Run the policy's mean action for `steps` steps."""
    found = FirstEnds(np.full(env.num_envs, steps), np.full(env.num_envs, "", dtype="<U8"))
    observations, _ = env.reset(seed=seed)
    for step in range(steps):
        actions, _ = policy.predict(observations, deterministic=True)
        observations, _, terminated, _, infos = env.step(actions)
        first = terminated & (found.reasons == "")
        if first.any():
            found.steps[first], found.reasons[first] = step, infos["final_info"]["end"][first]
    return found


def before_after(policy: AdaptNetPolicy, env: AdaptVectorEnv, seed: int = 0) -> Image:
    """Pictures (height, width, 3) of six seconds in one world: the base above, the adaptation below.

    Of the worlds in which the adaptation lasts longest, and longer than its base if there is such a one, it is the one
    in which the base lasts as long as it usually does there; a row ends as the episode does, by a fall or, say, lost.
    The policy keeps its alpha.

    Args:
        policy: an adaptation.
        env: worlds without a time limit (`open_worlds`).
        seed: of start states and goals.

    Raises:
        RenderingError: if this machine cannot draw.
    """
    kept, steps = policy.alpha, round(SECONDS / CONTROL_DT)
    alphas = {"before": 0.0, "after": kept}
    env.set_goal(None, None)
    ends = {}
    try:
        for caption, alpha in alphas.items():
            policy.alpha = alpha
            ends[caption] = first_ends(policy, env, seed, steps)
        world = _typical(ends["before"].steps, ends["after"].steps)
        rows = []
        for caption, alpha in alphas.items():
            policy.alpha = alpha
            end = int(ends[caption].steps[world]), str(ends[caption].reasons[world])
            rows.append(_row(policy, env, seed, caption, world, *end))
    finally:
        policy.alpha = kept
    return tiled(rows, COLUMNS)


def write_before_after(policy: AdaptNetPolicy, env: AdaptVectorEnv, path: str | Path, seed: int = 0) -> None:
    """Write `before_after` as a PNG."""
    write_png(before_after(policy, env, seed), path)


def _typical(before: NDArray[np.int64], after: NDArray[np.int64]) -> int:
    worlds = np.flatnonzero(after == after.max())
    outlasted = worlds[before[worlds] < after.max()]
    worlds = outlasted if len(outlasted) else worlds
    return int(worlds[before[worlds].argsort(kind="stable")[len(worlds) // 2]])


def _row(
    policy: AdaptNetPolicy, env: AdaptVectorEnv, seed: int, caption: str, world: int, end: int, reason: str
) -> list[Image]:
    """Tiles of `world` at equal intervals until its episode ends after `end` steps, and of the moment before that."""
    steps = round(SECONDS / CONTROL_DT)
    moments = [round(i * steps / (COLUMNS - 1)) for i in range(COLUMNS)]
    moments = [m for m in moments if m < end] + ([end] if end < steps else [steps])
    camera = _CAMERA if env.worlds.ground.obstacles is None else HIGH
    renderer, tiles = SceneRenderer(env.worlds, _TILE), []
    try:
        observations, _ = env.reset(seed=seed)
        for step in range(moments[-1] + 1):
            if step in moments:
                moment = f"{caption}, {step * CONTROL_DT:.1f} s" + (f", {reason}" if step == end < steps else "")
                tiles.append(captioned(renderer.picture(world, camera), moment))
            actions, _ = policy.predict(observations, deterministic=True)
            observations, *_ = env.step(actions)
    finally:
        renderer.close()
    return tiles
