"""Every environment as a row of one table: a new world is a new row."""

from dataclasses import dataclass, fields, replace

from adapt_envs.motion.clip import MotionClip
from adapt_envs.motion.library import STYLES

WALK_SPEEDS, RUN_SPEEDS = (1.0, 1.5), (1.0, 3.0)
"""Ranges of the preferred speed [m/s]; paper, app. A."""
WALK_TIMER, RUN_TIMER = (3.0, 5.0), (2.0, 3.0)
"""Ranges of the time until a new target is drawn [s]; paper, app. A."""
EPISODE_STEPS = 300
"""Control steps until the time limit: 10 s."""


@dataclass(frozen=True)
class TaskSpec:
    """One environment.

    Attributes:
        motion: name or file of the reference clip.
        base: name of the pretrained policy that is adapted by default.
        summary: one sentence for the documentation.
        speed_range: preferred speeds [m/s]; None for the paper's, or the clip's speed +-20 % where that lies outside.
        timer_range: seconds until a new target is drawn.
        friction: sliding friction of the ground.
    """

    motion: str
    base: str = "walk"
    summary: str = ""
    speed_range: tuple[float, float] | None = None
    timer_range: tuple[float, float] = WALK_TIMER
    friction: float = 1.0


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

SUITE: dict[str, TaskSpec] = {
    "Walk": TaskSpec("walk", summary="Walk to targets; what the base `walk` is trained on.", speed_range=WALK_SPEEDS),
    "Run": TaskSpec(
        "run", base="run", summary="Run to targets; what the base `run` is trained on.",
        speed_range=RUN_SPEEDS, timer_range=RUN_TIMER,
    ),
    "Style": TaskSpec("Stoop", summary="Walk to targets in the style of `motion=`, a clip's name or file."),
    **{name: TaskSpec(name, summary=f"{_STYLE_WORDS[name].capitalize()}, steered to targets.") for name in STYLES},
}  # fmt: skip
"""Environments by name; the Gymnasium id is `AdaptNet/Humanoid-NAME-v0`."""


def find(name: str) -> TaskSpec:
    """The row called `name`.

    Raises:
        ValueError: if there is none, listing the names.
    """
    if name not in SUITE:
        raise ValueError(f"no environment is named {name!r}; the names are {', '.join(SUITE)}")
    return SUITE[name]


def preferred_speeds(spec: TaskSpec, clip: MotionClip) -> tuple[float, float]:
    """Range [m/s] the preferred speed is drawn from: the row's, else the paper's or the clip's speed +-20 %."""
    if spec.speed_range is not None:
        return spec.speed_range
    usual = RUN_SPEEDS if spec.base == "run" else WALK_SPEEDS
    if usual[0] <= clip.mean_speed <= usual[1]:
        return usual
    return round(0.8 * clip.mean_speed, 3), round(1.2 * clip.mean_speed, 3)


def configured(task: str | TaskSpec, overrides: dict[str, object]) -> TaskSpec:
    """The row `task` with fields replaced.

    Raises:
        ValueError: for an unknown task or field, listing the valid ones, or a range that is not two rising numbers.
    """
    spec = find(task) if isinstance(task, str) else task
    valid = [item.name for item in fields(TaskSpec) if item.name not in ("base", "summary")]
    unknown = [key for key in overrides if key not in valid]
    if unknown:
        raise ValueError(f"unknown argument {unknown[0]!r}; the arguments are {', '.join(valid)}")
    for key in ("speed_range", "timer_range"):
        if overrides.get(key) is not None:
            overrides[key] = _checked_range(key, overrides[key])
    return replace(spec, **overrides)  # type: ignore[arg-type]


def _checked_range(name: str, value: object) -> tuple[float, float]:
    try:
        low, high = (float(number) for number in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}, expected two numbers") from None
    if not 0 < low <= high:
        raise ValueError(f"{name} is {value!r}, expected 0 < low <= high")
    return low, high
