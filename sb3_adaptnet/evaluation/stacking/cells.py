"""Measuring a pair of adaptations in the world of both: the base, either alone, and their sum."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from adapt_envs import AdaptVectorEnv, TaskSpec
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.progress import Progress
from sb3_adaptnet.evaluation.alpha import record_base
from sb3_adaptnet.evaluation.gait import Gait, clip_gait
from sb3_adaptnet.evaluation.imitation_error import BOUNDED, imitation_error
from sb3_adaptnet.evaluation.recording import WORLDS, record, record_straight
from sb3_adaptnet.evaluation.style import rounded, style_figures
from sb3_adaptnet.policies.adaptnet import TRAINED, AdaptNetPolicy
from sb3_adaptnet.policies.loading import load_policy
from sb3_adaptnet.stacking.parts import Pair, Part

ACTING = ("base", "first", "second", "both")
"""Who is measured in each pair's world."""
WEIGHTS = ((1.0, 1.0), (1.0, 1.2), (0.9, 1.0), (0.9, 1.2), (1.0, 0.8), (1.0, 1.4), (1.1, 1.1))
"""How strongly the first and the second may act in a sum whose weights are found; full strength is tried first."""
_ANOTHER = 1000
"""Weights are found with a seed that is this much larger than the one that is measured."""
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
        weights: how strongly the first and the second acted; 1 is their full strength.
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
    weights: tuple[float, float]
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
    base_speeds: bool = False, find_weights: bool = False,
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
        find_weights: whether the sum acts with the weights of `WEIGHTS` that do best with another seed, and not at full
            strength.

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
        stack = _Stack(pair, env, steps, progress, None if style is None else errors[style.name])
        weights = stack.find_weights(seed + _ANOTHER) if find_weights else (1.0, 1.0)
        strengths = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), weights)
        yield [stack.cell(acting, each, seed) for acting, each in zip(ACTING, strengths, strict=True)]


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
    straight, reference = record_base(_opened(style, env), env, seed, progress), env.worlds.reference
    return None if straight is None else imitation_error(straight, reference.clips[0], BOUNDED, reference.model).mean


class _Stack:
    """Two adaptations in the world of both, acting as strongly as one likes."""

    def __init__(
        self, pair: Pair, env: AdaptVectorEnv, steps: int, progress: Progress, base_error: float | None
    ) -> None:
        self.pair, self.env, self.steps, self.progress, self.base_error = pair, env, steps, progress, base_error
        self.policy = _opened(pair.first, env)
        self.second = self.policy.add_adaptation(pair.second.file)
        self.expected: Gait | None = None
        if pair.first.kind == "style":
            reference = env.worlds.reference
            self.expected = clip_gait(reference.clips[0], reference.shown.mean_speed, reference.model)

    def find_weights(self, seed: int) -> tuple[float, float]:
        """The first of `WEIGHTS` whose sum adds up without a fall, or what comes nearest to that."""
        best: Cell | None = None
        for weights in WEIGHTS:
            found = self.cell("both", weights, seed)
            best = found if best is None or _rank(found) < _rank(best) else best
            if best.adds_up and best.falls_per_minute == 0:
                break
        assert best is not None
        return best.weights

    def cell(self, acting: str, weights: tuple[float, float], seed: int) -> Cell:
        """Figures with these weights of the first and the second."""
        self.policy.blend({TRAINED: weights[0], self.second: weights[1]})
        free = record(self.policy, self.env, self.steps, seed, self.progress)
        error, visible = None, None
        failed: tuple[str, ...] = ()
        if self.expected is not None:
            speed = self.env.worlds.reference.shown.mean_speed
            straight = record_straight(self.policy, self.env, speed, seed, progress=self.progress)
            style = style_figures(self.env, straight, self.base_error, self.expected)
            error, visible, failed = style.tempo_error_m, style.visible, style.failed_tests
        return Cell(
            first=self.pair.first.name,
            second=self.pair.second.name,
            kinds=" + ".join(self.pair.kinds),
            acting=acting,
            weights=weights,
            speeds="{:g}-{:g}".format(*(self.env.worlds.spec.speed_range or (0, 0))),
            goal_reward=rounded(free.rewards.mean()),
            falls_per_minute=rounded(60 * free.restarts.sum() / free.seconds),
            tempo_error_m=error,
            visible=visible,
            failed_tests=failed,
            seconds=rounded(free.seconds),
            seed=seed,
        )


def _rank(cell: Cell) -> tuple[bool, int, float]:
    """Smaller is better: what adds up before what does not, then fewer failed tests, then fewer falls."""
    return not cell.adds_up, len(cell.failed_tests), cell.falls_per_minute
