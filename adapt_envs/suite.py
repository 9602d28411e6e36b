"""Every environment as a row of one table: a new world is a new row."""

from dataclasses import dataclass, fields, replace
from typing import Any

from adapt_envs.model.morphology import Morphology
from adapt_envs.model.obstacles import ObstacleField
from adapt_envs.model.terrain import Terrain
from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.library import STYLES
from adapt_envs.tables import entry
from adapt_envs.tasks.push import PushSchedule
from adapt_envs.tasks.row_values import CHECKS

WALK_SPEEDS, RUN_SPEEDS = (1.0, 1.5), (1.0, 3.0)
"""Ranges of the preferred speed [m/s]; paper, app. A."""
WALK_TIMER, RUN_TIMER = (3.0, 5.0), (2.0, 3.0)
"""Ranges of the time until a new target is sampled [s]; paper, app. A."""
STANDING = 0.02
"""Who is slower [m/s] does not walk."""
EPISODE_STEPS = 300
"""Control steps until the time limit: 10 s."""
ICE_WALK, ICE_RUN = 0.15, 0.35
"""Sliding friction of ice; paper, sec. 8.3."""
FALL_HEIGHT = 0.15
"""On uneven ground a link that touches it has fallen if it is lower than this [m]: the authors' release."""


@dataclass(frozen=True)
class TaskSpec:
    """One environment.

    Attributes:
        motion: name or file of the reference clip.
        base: name of the pretrained policy that is adapted by default.
        summary: one sentence for the documentation.
        speed_range: preferred speeds [m/s]; None for the paper's, or the clip's speed +-20 % where that lies outside.
        timer_range: seconds until a new target is sampled.
        friction: sliding friction of the ground.
        morphology: body shape, or its name in `MORPHOLOGIES`; None for the plain character's.
        locked: joints that are removed, such as `("right_knee",)`; see `locks.joints_named`.
        terrain: function that samples the ground's heights, or its name in `TERRAINS`; None for flat ground.
        terrain_seed: seed of terrain and obstacles; `reset(seed=...)` is for spawns and goals only.
        terrain_scale: the terrain's heights are multiplied by this: above 1 for harder ground than the paper's.
        obstacles: how blocks are laid out, or the layout's name in `OBSTACLES`; None for free ground.
        heightmap: whether the observation holds a heightmap of the ground around the character.
        fall_height: a link that touches the ground from this height [m] or more has not fallen; None if any touch is a
            fall. Counted from its origin, a shin's being the knee; see `tasks.termination`.
        push: when and how hard the character is pushed; None for never.
        clip_on_body: whether reference windows show the clip on this body, with its joint angles, and not on the plain
            character (paper, sec. 8.2: motions are not retargeted).
    """

    motion: str
    base: str = "walk"
    summary: str = ""
    speed_range: tuple[float, float] | None = None
    timer_range: tuple[float, float] = WALK_TIMER
    friction: float = 1.0
    morphology: str | Morphology | None = None
    locked: tuple[str, ...] = ()
    terrain: str | Terrain | None = None
    terrain_seed: int = 0
    terrain_scale: float = 1.0
    obstacles: str | ObstacleField | None = None
    heightmap: bool = False
    fall_height: float | None = None
    push: PushSchedule | None = None
    clip_on_body: bool = False

    def __post_init__(self) -> None:
        """Check the values.

        Raises:
            ValueError: for one of another kind, a range that does not rise, or a number that cannot be.
        """
        for name, check in CHECKS.items():
            object.__setattr__(self, name, check(name, getattr(self, name)))


_STYLE_WORDS = {
    "Swaggering": "exaggerated walking with one arm akimbo",
    "GooseStep": "goose step with arms akimbo",
    "Stomp": "walking while stomping on the ground",
    "Kicking": "walking with leg kicking",
    "Stoop": "slow walking with the body bent over",
    "JauntySkip": "skipping in a spirited manner",
    "Sashay": "walking in a slightly exaggerated manner",
    "Limp": "slow walking with the right leg hurt",
    "Pace": "slow walking with arms akimbo",
    "Penguin": "moving with very small steps",
    "Strutting": "walking with the shoulders moving aggressively",
    "Joyful": "strut walking rhythmically",
}

_WALK = TaskSpec("walk", speed_range=WALK_SPEEDS)
_RUN = TaskSpec("run", base="run", speed_range=RUN_SPEEDS, timer_range=RUN_TIMER)

_SHAPES = {
    "LongBody": ("long_body", "an abdomen half as long again"),
    "BigBody": ("big_body", "a torso 1.5 times as large and 3.4 times as heavy"),
    "LongUpperArms": ("long_upper_arms", "upper arms 25 % longer"),
    "LongLowerArms": ("long_lower_arms", "lower arms 25 % longer"),
    "AsymmetricUpperArms": ("asymmetric_upper_arms", "the right upper arm 25 % longer, the left one 25 % shorter"),
    "LongThighs": ("long_thighs", "thighs half as long again"),
    "LongShins": ("long_shins", "shins half as long again, as on stilts"),
    "SuperLongLegs": ("super_long_legs", "thighs and shins half as long again: over 2 m tall"),
}
_LOCKS = {
    "LockedAbdomen": (("abdomen",), "a stiff abdomen"),
    "LockedElbows": (("elbow",), "stiff elbows"),
    "LockedAnkles": (("ankle",), "stiff ankles"),
    "LockedRightKnee": (("right_knee",), "a stiff right knee"),
}
_TERRAIN = {
    "TerrainHills": ("hills", "smooth hills"),
    "TerrainRocky": ("rocky", "rocky ground with steps"),
    "TerrainRugged": ("rugged", "rugged slopes"),
}


def _bodies() -> dict[str, TaskSpec]:
    """Every body shape and every lock, running and walking."""
    rows: dict[str, tuple[dict[str, Any], str]] = {
        name: ({"morphology": shape}, words) for name, (shape, words) in _SHAPES.items()
    }
    rows |= {name: ({"locked": joints}, words) for name, (joints, words) in _LOCKS.items()}
    return {
        name + suffix: replace(plain, summary=f"{verb} with {words}.", **change)
        for suffix, verb, plain in (("", "Run", _RUN), ("Walk", "Walk", _WALK))
        for name, (change, words) in rows.items()
    }


SUITE: dict[str, TaskSpec] = {
    "Walk": replace(_WALK, summary="Walk to targets; what the base `walk` is trained on."),
    "Run": replace(_RUN, summary="Run to targets; what the base `run` is trained on."),
    "Style": TaskSpec("Stoop", summary="Walk to targets in the style of `motion=`, a clip's name or file."),
    **{name: TaskSpec(name, summary=f"{_STYLE_WORDS[name].capitalize()}, steered to targets.") for name in STYLES},
    **_bodies(),
    "IceWalk": replace(_WALK, friction=ICE_WALK, summary="Walk on ice of friction 0.15."),
    "IceRun": replace(_RUN, friction=ICE_RUN, summary="Run on ice of friction 0.35."),
    **{
        name: replace(
            _WALK,
            terrain=kind,
            heightmap=True,
            fall_height=FALL_HEIGHT,
            summary=f"Walk on {words}, seen through a heightmap.",
        )  # fmt: skip
        for name, (kind, words) in _TERRAIN.items()
    },
    "Obstacles": replace(
        _WALK, obstacles="blocks", heightmap=True, summary="Walk between blocks, seen through a heightmap."
    ),
    "PushWalk": replace(_WALK, push=PushSchedule(), summary="Walk while being pushed, 1000 N for 0.2 s."),
    "PushRun": replace(_RUN, push=PushSchedule(), summary="Run while being pushed, 1000 N for 0.2 s."),
}
"""Environments by name; the Gymnasium id is `AdaptNet/Humanoid-NAME-v0`."""


def find(name: str) -> TaskSpec:
    """The row called `name`.

    Raises:
        ValueError: if there is none, listing the names.
    """
    return entry("environment", SUITE, name)


def preferred_speeds(spec: TaskSpec, clip: MotionClip, shown: MotionClip | None = None) -> tuple[float, float]:
    """Range [m/s] the preferred speed is sampled from: the row's, else the paper's or the clip's speed +-20 %.

    Args:
        spec: the row.
        clip: its clip.
        shown: the clip as the row's body shows it (`shown_by`); None for the plain character.

    Raises:
        MotionError: if the clip stands still, and the row has no range.
    """
    if spec.speed_range is not None:
        return spec.speed_range
    usual = RUN_SPEEDS if spec.base == "run" else WALK_SPEEDS
    if usual[0] <= clip.mean_speed <= usual[1]:
        return usual
    speed = (shown or clip).mean_speed
    if speed < STANDING:
        raise MotionError(f"clip {clip.name!r} goes nowhere ({speed:.2f} m/s); give speed_range=(low, high)")
    return round(0.8 * speed, 3), round(1.2 * speed, 3)


def configured(task: str | TaskSpec, overrides: dict[str, Any]) -> TaskSpec:
    """The row `task` with fields replaced.

    Raises:
        ValueError: for an unknown task or field, listing the valid ones, or a value that a `TaskSpec` refuses.
    """
    spec = find(task) if isinstance(task, str) else task
    valid = [item.name for item in fields(TaskSpec) if item.name not in ("base", "summary")]
    unknown = [key for key in overrides if key not in valid]
    if unknown:
        raise ValueError(f"unknown argument {unknown[0]!r}; the arguments are {', '.join(valid)}")
    return replace(spec, **overrides)
