"""The paths that the base motions follow: speed and heading over time, sampled from a seed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from adapt_envs.motion.dynamics import GRAVITY

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Command:
    """A stretch of path.

    Attributes:
        seconds: duration.
        speed: wanted at its end [m/s].
        turn: change of heading [rad], left positive.
        rate: how fast the heading changes [rad/s]; the turn starts with the stretch.
    """

    seconds: float
    speed: float
    turn: float = 0.0
    rate: float = 2.0


Span = tuple[float, float]
"""Lowest and highest number that is sampled."""
Chapter = Callable[[np.random.Generator], list[Command]]
"""Some commands that belong together, sampled."""


@dataclass(frozen=True)
class Path:
    """A path sampled evenly in time.

    Attributes:
        t: (T,) times [s].
        pos: (T, 2) place of the body [m].
        heading: (T,) direction of travel [rad], continuous.
        speed: (T,) [m/s].
        rate: (T,) turning rate [rad/s].
        carry: (T, 2) where the ground must carry the body: pos - acceleration z / g [m].
        acc: (T, 2) its acceleration [m/s^2].
    """

    t: Array
    pos: Array
    heading: Array
    speed: Array
    rate: Array
    carry: Array
    acc: Array

    def at(self, values: Array, time: float | Array) -> Array:
        """Values along the path (T,) or (T, 2) at a time."""
        if values.ndim == 1:
            return np.asarray(np.interp(time, self.t, values))
        return np.stack([np.interp(time, self.t, column) for column in values.T], axis=-1)


def follow(commands: list[Command], dt: float, sideways: float, ease: float, height: float = 0.93) -> Path:
    """Smooth path through commands.

    Args:
        commands: stretches one after the other.
        dt: time step [s].
        sideways: largest sideways acceleration [m/s^2]: sharp turns are slowed down to it.
        ease: width of the smoothing of the speed [s].
        height: of the centre of mass [m].
    """
    speed, rate = (np.concatenate(parts) for parts in zip(*(_stretch(c, dt) for c in commands), strict=True))
    rate = gaussian_filter1d(rate, 0.09 / dt, mode="nearest")
    # A dip of speed that begins before the turn: the fourth power keeps gentle arcs at full speed.
    dip = (1 + (np.abs(gaussian_filter1d(rate, 0.18 / dt)) * speed / sideways) ** 4) ** -0.25
    speed = gaussian_filter1d(speed * dip, ease / dt, mode="nearest")
    heading = np.cumsum(rate) * dt
    velocity = speed[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    pos = np.cumsum(velocity, axis=0) * dt
    acc = np.gradient(velocity, dt, axis=0)
    t = np.asarray(np.arange(len(speed)) * dt, dtype=np.float64)
    return Path(t, pos, heading, speed, rate, pos - acc * height / GRAVITY, acc)


def _stretch(command: Command, dt: float) -> tuple[Array, Array]:
    n = round(command.seconds / dt)
    rate = np.zeros(n)
    turning = min(n, max(1, round(abs(command.turn) / command.rate / dt)))
    rate[:turning] = command.turn / (turning * dt)
    return np.full(n, command.speed), rate


def walking_commands(seconds: float, seed: int) -> list[Command]:
    """Everything a walker does: new goals in any direction, arcs, starts, stops, turns on the spot, all speeds."""
    goals = partial(_goals, count=2, seconds=(2.5, 4.0), speed=(0.95, 1.5), rate=(105, 160))
    arcs = partial(_arcs, seconds=(2.5, 4.0), speed=(0.7, 1.4))
    chapters = (goals, goals, goals, arcs, _stop, goals, goals, _slow, _straight)
    return _filled([Command(2.0, 1.2)], chapters, seconds, np.random.default_rng(seed))


def running_commands(seconds: float, seed: int) -> list[Command]:
    """Everything a runner does: new goals in any direction every 2-3 s, arcs, straights, 1 to 3.5 m/s."""
    goals = partial(_goals, count=3, seconds=(2.0, 3.2), speed=(1.1, 3.5), rate=(95, 145))
    arcs = partial(_arcs, seconds=(2.0, 4.0), speed=(1.3, 3.0))
    chapters = (goals, goals, arcs, goals, _run_straight)
    return _filled([Command(2.0, 2.0)], chapters, seconds, np.random.default_rng(seed))


def _filled(
    commands: list[Command], chapters: Sequence[Chapter], seconds: float, rng: np.random.Generator
) -> list[Command]:
    while sum(c.seconds for c in commands) < seconds:
        for chapter in chapters:
            commands += chapter(rng)
    return commands


def _angle(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.radians(rng.uniform(low, high)) * rng.choice((-1, 1)))


def _goals(rng: np.random.Generator, count: int, seconds: Span, speed: Span, rate: Span) -> list[Command]:
    """What the goal task asks for: a new heading, uniform in all directions, and a new speed [m/s], every few seconds.

    The heading turns at a `rate` [degrees/s].
    """
    return [
        Command(rng.uniform(*seconds), rng.uniform(*speed), _angle(rng, 5, 180), np.radians(rng.uniform(*rate)))
        for _ in range(count)
    ]


def _arcs(rng: np.random.Generator, seconds: Span, speed: Span) -> list[Command]:
    commands = []
    for _ in range(2):
        length, rate = rng.uniform(*seconds), rng.uniform(15, 60)
        commands.append(Command(length, rng.uniform(*speed), _angle(rng, 1, 1) * rate * length, np.radians(rate)))
    return commands


def _stop(rng: np.random.Generator) -> list[Command]:
    halt = Command(rng.uniform(2.2, 3.2), 0.0)
    away = Command(rng.uniform(2.5, 3.5), rng.uniform(0.9, 1.4), _angle(rng, 0, 140), np.radians(rng.uniform(90, 130)))
    return [Command(rng.uniform(1.5, 2.5), rng.uniform(0.9, 1.4)), halt, away]


def _slow(rng: np.random.Generator) -> list[Command]:
    slow = Command(rng.uniform(2.5, 3.5), rng.uniform(0.3, 0.8), _angle(rng, 0, 120), np.radians(rng.uniform(50, 90)))
    return [slow, Command(rng.uniform(2.0, 3.0), rng.uniform(0.6, 1.0), _angle(rng, 20, 150), np.radians(100))]


def _straight(rng: np.random.Generator) -> list[Command]:
    fast = Command(rng.uniform(2.0, 3.0), rng.uniform(1.2, 1.6), _angle(rng, 0, 20))
    return [fast, Command(2.5, rng.uniform(1.0, 1.6))]


def _run_straight(rng: np.random.Generator) -> list[Command]:
    fast = Command(rng.uniform(3.0, 4.0), rng.uniform(2.8, 3.6), _angle(rng, 0, 15))
    return [fast, Command(2.0, rng.uniform(1, 2))]
