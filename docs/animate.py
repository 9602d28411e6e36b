"""Draws the animated pictures of the environments' pages: `python docs/animate.py [NAME ...]`.

`--films FOLDER` writes the same worlds as films. Needs the project installed and OpenGL; a picture takes
seconds on one core for each pane, a film ten times as long.
"""

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from adapt_envs import AdaptVectorEnv, env_id
from adapt_envs.drawing.film import write_video
from adapt_envs.drawing.picture import Image, tiled
from adapt_envs.model import CONTROL_DT
from sb3_adaptnet import load_policy
from sb3_adaptnet.evaluation import open_worlds
from sb3_adaptnet.evaluation.pictures import captioned
from sb3_adaptnet.evaluation.recording import Acting
from sb3_adaptnet.policies.adaptnet import TRAINED, AdaptNetPolicy
from sb3_adaptnet.publishing.pictures import world_frames
from sb3_adaptnet.stacking import Pair, Part, part_of

FOLDER = Path(__file__).parent / "families"


class Pane(NamedTuple):
    """Who is shown where.

    Attributes:
        policy: name of a shipped policy.
        environment: short name of the environment.
    """

    policy: str
    environment: str

    @property
    def caption(self) -> str:
        """Words of the pane: the policy, and where it walks if its name does not tell."""
        own = self.environment.lower() in self.policy
        return self.policy if own else f"{self.policy} in {self.environment}"


class Stack(NamedTuple):
    """Two shipped adaptations at once, in the world of both."""

    first: str
    second: str

    @property
    def caption(self) -> str:
        """Both names, without their base's."""
        return " + ".join(name.partition("-")[2] for name in self)


class Picture(NamedTuple):
    """Worlds side by side.

    Attributes:
        panes: row by row.
        columns: panes in a row.
        side: of a pane in the animated picture [pixels]; in the film each is of `FILM_SIDE`.
    """

    panes: tuple[Pane | Stack, ...]
    columns: int
    side: int = 220


def _beneath(pairs: tuple[tuple[str, str], ...]) -> tuple[Pane, ...]:
    """Adaptations (base, environment) in a row beneath their bases."""
    bases = [Pane(base, name) for base, name in pairs]
    return (*bases, *(Pane(f"{base}-{name.lower()}", name) for base, name in pairs))


def _stacks(rows: Mapping[str, tuple[str, ...]]) -> tuple[Stack, ...]:
    """A row of styles for each body or ground."""
    pairs = [(style, world) for world, styles in rows.items() for style in styles]
    return tuple(Stack(*(f"walk-{name.lower()}" for name in pair)) for pair in pairs)


STYLES = ("Stoop", "Penguin", "Stomp", "Kicking", "GooseStep", "JauntySkip", "Swaggering", "Sashay", "Limp", "Pace",
          "Strutting", "Joyful")  # fmt: skip
BODIES = (("walk", "LongShinsWalk"), ("walk", "LongThighsWalk"), ("walk", "SuperLongLegsWalk"), ("run", "LongShins"),
          ("run", "LongThighs"))  # fmt: skip
LOCKS = (("walk", "LockedRightKneeWalk"), ("walk", "LockedAnklesWalk"), ("run", "LockedRightKnee"))
GROUNDS = (("walk", "IceWalk"), ("walk", "TerrainHills"), ("walk", "TerrainRugged"), ("walk", "Obstacles"))
STACKS = {
    "LongBodyWalk": ("Stoop", "Stomp", "Strutting", "Joyful"),
    "BigBodyWalk": ("Penguin", "Kicking", "GooseStep", "JauntySkip"),
    "LongThighsWalk": ("Stoop", "Penguin", "Swaggering", "Limp"),
    "LongShinsWalk": ("Pace", "Joyful", "Sashay", "Stomp"),
    "SuperLongLegsWalk": ("Pace", "Stomp", "Sashay", "Strutting"),
}
PICTURES = {
    "bases": Picture((Pane("walk", "Walk"), Pane("run", "Run")), 2),
    "styles": Picture(tuple(Pane(f"walk-{name.lower()}", name) for name in STYLES), 4, 180),
    "bodies": Picture(_beneath(BODIES), len(BODIES), 160),
    "locks": Picture(_beneath(LOCKS), len(LOCKS)),
    "ice": Picture(_beneath(GROUNDS[:1]), 2),
    "terrain": Picture(_beneath(GROUNDS[1:]), 3),
    "stacks": Picture(_stacks(STACKS), 4, 160),
    "pushes": Picture((Pane("walk-pushwalk", "PushWalk"), Pane("run-pushrun", "PushRun")), 2),
}
"""File -> what it shows."""
EVERY, SECONDS, QUALITY = 2, 4.0, 32
"""Of animated pictures: control steps from one frame to the next, length [s], WebP's quality up to 100."""
FILM_SIDE, FILM_SECONDS = 320, 12.0
"""Of films: side of a pane [pixels] and length [s]."""


def opened(pane: Pane | Stack) -> tuple[Acting, AdaptVectorEnv]:
    """The pane's policy and its one world."""
    if isinstance(pane, Stack):
        return _stacked(*(part_of(name) for name in pane))
    env = open_worlds(env_id(pane.environment), 1, num_threads=1)
    return load_policy(pane.policy, env), env


def _stacked(first: Part, second: Part) -> tuple[Acting, AdaptVectorEnv]:
    env = AdaptVectorEnv(Pair(first, second).world, 1, num_threads=1, max_episode_steps=None)
    policy = load_policy(first.file, env)
    assert isinstance(policy, AdaptNetPolicy)
    policy.blend({TRAINED: 1.0, policy.add_adaptation(second.file): 1.0})
    return policy, env


def frames_of(picture: Picture, side: int, every: int, seconds: float) -> Iterator[Image]:
    """The panes side by side as time goes on, small and captioned."""
    shown = [world_frames(*opened(pane), seconds, seed=1, every=every) for pane in picture.panes]
    for frames in zip(*shown, strict=True):
        small = [cv2.resize(frame, (side, side), interpolation=cv2.INTER_AREA) for frame in frames]
        panes = [
            captioned(np.asarray(frame, np.uint8), pane.caption)
            for frame, pane in zip(small, picture.panes, strict=True)
        ]
        rows = [panes[first : first + picture.columns] for first in range(0, len(panes), picture.columns)]
        yield tiled(rows, picture.columns)


def animate(name: str) -> Path:
    """Draw one animated picture; return its file."""
    animation = cv2.Animation()
    frames = frames_of(PICTURES[name], PICTURES[name].side, EVERY, SECONDS)
    animation.frames = [cv2.cvtColor(frame, cv2.COLOR_RGB2BGR) for frame in frames]
    animation.durations = np.full(len(animation.frames), round(1000 * EVERY * CONTROL_DT))
    file = FOLDER / f"{name}.webp"
    if not cv2.imwriteanimation(str(file), animation, [cv2.IMWRITE_WEBP_QUALITY, QUALITY]):
        raise OSError(f"{file} cannot be written")
    return file


def film(name: str, folder: Path) -> Path:
    """Write the same worlds as a film into a folder; return its file."""
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{name}.mp4"
    write_video(frames_of(PICTURES[name], FILM_SIDE, 1, FILM_SECONDS), file)
    return file


def main() -> None:
    """Draw the pictures that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0] if __doc__ else "")
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(PICTURES))
    parser.add_argument("--films", metavar="FOLDER", help="write films of twelve seconds there, and no pictures")
    options = parser.parse_args()
    names = options.names
    unknown = [name for name in names if name not in PICTURES]
    if unknown:
        parser.error(f"no picture is named {unknown[0]!r}; the names are {', '.join(PICTURES)}")
    for name in names or PICTURES:
        file = animate(name) if options.films is None else film(name, Path(options.films))
        print(f"wrote {file}, {file.stat().st_size / 1000:.0f} kB", flush=True)


if __name__ == "__main__":
    main()
