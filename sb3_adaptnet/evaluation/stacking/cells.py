"""Measuring a pair of adaptations in the world of both: the base, either alone, and their sum."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from adapt_envs import AdaptVectorEnv, TaskSpec
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.progress import Progress
from sb3_adaptnet.evaluation.alpha import record_base
from sb3_adaptnet.evaluation.gait import clip_gait
from sb3_adaptnet.evaluation.imitation_error import BOUNDED, imitation_error
from sb3_adaptnet.evaluation.recording import WORLDS, record, record_straight
from sb3_adaptnet.evaluation.style import rounded, style_figures
from sb3_adaptnet.policies.adaptnet import TRAINED, AdaptNetPolicy
from sb3_adaptnet.policies.loading import load_policy
from sb3_adaptnet.stacking.parts import Pair, Part

ACTING = ("base", "first", "second", "both")
"""Who is measured in each pair's world."""
MOST_FALLS = 0.5
"""Falls per minute of a sum that adds up, at most."""


@dataclass(frozen=True)
class Cell:
    """Figures of one policy in the world of a pair; those of a style are None where the pair has none.

    Attributes:
        first: name of the first adaptation.
        second: name of the second.
        kinds: what the two are, such as "style + ground".
        acting: base, first, second or both: who was measured.
        speeds: preferred speeds of the random goals [m/s], such as "0.51-0.765".
        goal_reward: mean goal reward of a step, random goals.
        falls_per_minute: episodes that ended by a fall, by getting lost or by diverging, per simulated minute.
        tempo_error_m: distance to the style's clip [m] straight ahead (see `StyleFigures`); None also where no world
            stayed up for 3 s.
        visible: whether the style can be seen; the error is compared with the base's on plain ground.
        failed_tests: which tests of it failed, in words.
        seconds: simulated seconds with random goals, all worlds together.
        seed: of start states and goals.
    """

    first: str
    second: str
    kinds: str
    acting: str
    speeds: str
    goal_reward: float
    falls_per_minute: float
    tempo_error_m: float | None
    visible: bool | None
    failed_tests: tuple[str, ...]
    seconds: float
    seed: int

    @property
    def adds_up(self) -> bool:
        """Whether it falls 0.5 times a minute or less, and the style, if there is one, is visible."""
        return self.falls_per_minute <= MOST_FALLS and self.visible is not False


def measure_pairs(
    pairs: Iterable[Pair], seconds: float, seed: int, threads: int | None = None, progress: Progress = iter,
    base_speeds: bool = False,
) -> Iterator[list[Cell]]:  # fmt: skip
    """The four cells of each pair, as soon as they are measured.

    Args:
        pairs: what to measure.
        seconds: simulated seconds of each cell with random goals, all worlds together.
        seed: of start states and goals.
        threads: threads of the physics; None for one per core.
        progress: wraps the step numbers of each rollout.
        base_speeds: whether random goals have the base's speeds, which grounds, bodies and pushes were trained at, and
            not the style's. Straight ahead the speed is the clip's in any case.

    Raises:
        ValueError: if `seconds` is less than one step of all worlds, or an adaptation is not made of adaptors.
    """
    steps = round(seconds / WORLDS / CONTROL_DT)
    if steps < 1:
        raise ValueError(f"seconds is {seconds}, but one step of {WORLDS} worlds takes {WORLDS * CONTROL_DT:.2f}")
    errors: dict[str, float | None] = {}
    for pair in pairs:
        style = pair.first if pair.first.kind == "style" else None
        if style is not None and style.name not in errors:
            errors[style.name] = _base_error(style, seed, threads, progress)
        env = open_row(_with_base_speeds(pair) if base_speeds else pair.world, threads)
        yield _cells(pair, env, steps, seed, progress, None if style is None else errors[style.name])


def open_row(row: TaskSpec, threads: int | None) -> AdaptVectorEnv:
    """Worlds of a row of the suite without a time limit."""
    return AdaptVectorEnv(row, WORLDS, num_threads=threads, max_episode_steps=None)


def _with_base_speeds(pair: Pair) -> TaskSpec:
    return replace(pair.world, speed_range=pair.first.row.speed_range)


def _opened(part: Part, env: AdaptVectorEnv) -> AdaptNetPolicy:
    policy = load_policy(part.file, env, base=part.base)
    if not isinstance(policy, AdaptNetPolicy):
        raise ValueError(f"{part.name!r} is not made of adaptors that can be added to others")
    return policy


def _base_error(style: Part, seed: int, threads: int | None, progress: Progress) -> float | None:
    """The base's tempo-bounded error [m] on a style, on the ground that both were trained on."""
    env = open_row(style.world, threads)
    straight = record_base(_opened(style, env), env, seed, progress)
    return None if straight is None else imitation_error(straight, env.worlds.reference.clips[0], BOUNDED).mean


def _cells(
    pair: Pair, env: AdaptVectorEnv, steps: int, seed: int, progress: Progress, base_error: float | None
) -> list[Cell]:
    policy = _opened(pair.first, env)
    second = policy.add_adaptation(pair.second.file)
    weights: Sequence[dict[str, float]] = ({}, {TRAINED: 1.0}, {second: 1.0}, {TRAINED: 1.0, second: 1.0})
    found = []
    for acting, blend in zip(ACTING, weights, strict=True):
        policy.blend(blend)
        found.append(_cell(pair, acting, policy, env, steps, seed, progress, base_error))
    return found


def _cell(
    pair: Pair, acting: str, policy: AdaptNetPolicy, env: AdaptVectorEnv, steps: int, seed: int, progress: Progress,
    base_error: float | None,
) -> Cell:  # fmt: skip
    free, error, visible = record(policy, env, steps, seed, progress), None, None
    failed: tuple[str, ...] = ()
    if pair.first.kind == "style":
        reference = env.worlds.reference
        speed = reference.shown.mean_speed
        straight = record_straight(policy, env, speed, seed, progress=progress)
        expected = clip_gait(reference.clips[0], speed, reference.model)
        style = style_figures(env, straight, base_error, expected)
        error, visible, failed = style.tempo_error_m, style.visible, style.failed_tests
    return Cell(
        first=pair.first.name,
        second=pair.second.name,
        kinds=" + ".join(pair.kinds),
        acting=acting,
        speeds="{:g}-{:g}".format(*(env.worlds.spec.speed_range or (0, 0))),
        goal_reward=rounded(free.rewards.mean()),
        falls_per_minute=rounded(60 * free.restarts.sum() / free.seconds),
        tempo_error_m=error,
        visible=visible,
        failed_tests=failed,
        seconds=rounded(free.seconds),
        seed=seed,
    )
