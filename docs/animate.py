"""Draws the animated pictures of the environments' pages: `python docs/animate.py [NAME ...]`.

Needs the project installed and OpenGL; each takes half a minute or so on one core.
"""

import argparse
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from adapt_envs import env_id
from adapt_envs.drawing.picture import Image, tiled
from adapt_envs.model import CONTROL_DT
from sb3_adaptnet import load_policy
from sb3_adaptnet.evaluation import open_worlds
from sb3_adaptnet.evaluation.pictures import captioned
from sb3_adaptnet.publishing.pictures import world_frames

FOLDER = Path(__file__).parent / "families"
PICTURES = {
    "bases": (("walk", "Walk"), ("run", "Run")),
    "styles": (("walk-stoop", "Stoop"), ("walk-goosestep", "GooseStep"), ("walk-penguin", "Penguin")),
    "bodies": (("run", "LongShins"), ("run-longshins", "LongShins")),
    "locks": (("run", "LockedRightKnee"), ("run-lockedrightknee", "LockedRightKnee")),
    "ice": (("walk", "IceWalk"), ("walk-icewalk", "IceWalk")),
    "terrain": (("walk-terrainhills", "TerrainHills"), ("walk-obstacles", "Obstacles")),
    "pushes": (("walk-pushwalk", "PushWalk"),),
}
"""File -> (policy, environment) of every pane, from left to right."""
PANE, EVERY, SECONDS = 220, 2, 4.0
"""Side of a pane [pixels], control steps from a picture to the next, length [s]."""
QUALITY = 32
"""Of WebP, up to 100."""


def panes_of(policy: str, name: str) -> list[Image]:
    """Pictures of one world, small and captioned."""
    env = open_worlds(env_id(name), 1, num_threads=1)
    count = round(SECONDS / CONTROL_DT / EVERY)
    frames = islice(world_frames(load_policy(policy, env), env, SECONDS, seed=1, every=EVERY), count)
    small = [cv2.resize(frame, (PANE, PANE), interpolation=cv2.INTER_AREA) for frame in frames]
    return [captioned(np.asarray(frame, np.uint8), f"{policy} in {name}") for frame in small]


def animate(name: str) -> Path:
    """Draw one picture; return its file."""
    columns = [panes_of(policy, environment) for policy, environment in PICTURES[name]]
    frames = [tiled([row], len(row)) for row in zip(*columns, strict=True)]
    animation = cv2.Animation()
    animation.frames = [cv2.cvtColor(frame, cv2.COLOR_RGB2BGR) for frame in frames]
    animation.durations = np.full(len(frames), round(1000 * EVERY * CONTROL_DT))
    file = FOLDER / f"{name}.webp"
    if not cv2.imwriteanimation(str(file), animation, [cv2.IMWRITE_WEBP_QUALITY, QUALITY]):
        raise OSError(f"{file} cannot be written")
    return file


def main() -> None:
    """Draw the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
    names = parser.parse_args().names
    unknown = [name for name in names if name not in PICTURES]
    if unknown:
        parser.error(f"no picture is named {unknown[0]!r}; the names are {', '.join(PICTURES)}")
    for name in names or PICTURES:
        file = animate(name)
        print(f"wrote {file}, {file.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    main()
