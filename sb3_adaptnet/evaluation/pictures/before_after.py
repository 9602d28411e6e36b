"""An adaptation and its base in the same world from the same start, drawn beneath each other as time goes on."""

from pathlib import Path
from typing import NamedTuple

from adapt_envs import AdaptVectorEnv
from adapt_envs.drawing.picture import Image, tiled, write_png
from adapt_envs.drawing.scene import Camera
from adapt_envs.drawing.world_view import HIGH, SceneRenderer
from adapt_envs.model.humanoid import CONTROL_DT
from sb3_adaptnet.evaluation.pictures.strips import captioned
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy

SECONDS, COLUMNS = 6.0, 7
"""Simulated seconds that are shown, and the tiles that show them."""
_TILE = (270, 300)
"""Width and height of a tile [pixels]."""
_CAMERA = Camera(azimuth=120, elevation=-14, distance=5.6, fovy=28)
_STEPS = round(SECONDS / CONTROL_DT)


class FirstEnd(NamedTuple):
    """How a world's first episode ended.

    Attributes:
        steps: steps made before the one it ended in; all of them if it went on.
        reason: `info["end"]`, such as "fall"; "" if it went on.
    """

    steps: int
    reason: str


def check_world(world: int, env: AdaptVectorEnv) -> None:
    """Refuse a world that does not exist.

    Raises:
        ValueError: if `env` has no world of this number.
    """
    if not 0 <= world < env.num_envs:
        raise ValueError(f"there is no world {world}; they are 0 to {env.num_envs - 1}")


def before_after(policy: AdaptNetPolicy, env: AdaptVectorEnv, seed: int = 0, world: int = 0) -> Image:
    """Pictures (height, width, 3) of six seconds in one world: the base above, the adaptation below.

    A row ends as the world's first episode does, by a fall or, say, lost. The policy keeps its alpha.

    Args:
        policy: an adaptation.
        env: worlds without a time limit (`open_worlds`).
        seed: of start states and goals.
        world: number of the world that is drawn.

    Raises:
        ValueError: if there is no such world.
        RenderingError: if this machine cannot draw.
    """
    check_world(world, env)
    kept = policy.alpha
    env.set_goal(None, None)
    rows = []
    try:
        for caption, alpha in {"before": 0.0, "after": kept}.items():
            policy.alpha = alpha
            rows.append(_draw_row(policy, env, seed, caption, world))
    finally:
        policy.alpha = kept
    return tiled(rows, COLUMNS)


def write_before_after(
    policy: AdaptNetPolicy, env: AdaptVectorEnv, path: str | Path, seed: int = 0, world: int = 0
) -> None:
    """Write `before_after` as a PNG."""
    write_png(before_after(policy, env, seed, world), path)


def first_end(policy: AdaptNetPolicy, env: AdaptVectorEnv, seed: int, world: int) -> FirstEnd:
    """Run the policy's mean action until the world's first episode ends, or for six seconds."""
    observations, _ = env.reset(seed=seed)
    for step in range(_STEPS):
        actions, _ = policy.predict(observations, deterministic=True)
        observations, _, terminated, _, infos = env.step(actions)
        if terminated[world]:
            return FirstEnd(step, str(infos["final_info"]["end"][world]))
    return FirstEnd(_STEPS, "")


def _draw_row(policy: AdaptNetPolicy, env: AdaptVectorEnv, seed: int, caption: str, world: int) -> list[Image]:
    """Draw tiles of `world` at equal intervals until its episode ends, the last one of the moment before that."""
    end = first_end(policy, env, seed, world)
    moments = [m for m in (round(i * _STEPS / (COLUMNS - 1)) for i in range(COLUMNS)) if m < end.steps] + [end.steps]
    camera = _CAMERA if env.worlds.ground.obstacles is None else HIGH
    renderer, tiles = SceneRenderer(env.worlds, _TILE), []
    try:
        observations, _ = env.reset(seed=seed)
        for step in range(moments[-1] + 1):
            if step in moments:
                reason = f", {end.reason}" if step == end.steps < _STEPS else ""
                moment = f"{caption}, {step * CONTROL_DT:.1f} s{reason}"
                tiles.append(captioned(renderer.picture(world, camera), moment))
            actions, _ = policy.predict(observations, deterministic=True)
            observations, *_ = env.step(actions)
    finally:
        renderer.close()
    return tiles
