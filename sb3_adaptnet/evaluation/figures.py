"""The figures of one policy in one environment: what `adaptnet eval` prints."""

from dataclasses import dataclass

import numpy as np

from adapt_envs import AdaptVectorEnv
from adapt_envs.model.humanoid import CONTROL_DT
from adapt_envs.progress import Progress
from sb3_adaptnet.evaluation.imitation_error import imitation_error
from sb3_adaptnet.evaluation.recording import Acting, Recording, record, record_straight
from sb3_adaptnet.evaluation.smoothness import jerk_ratio, slips
from sb3_adaptnet.evaluation.style import StyleFigures, rounded, style_figures, tempo_error_of_base

DEFAULT_SECONDS = 1200.0
"""Simulated seconds of an evaluation, all worlds together."""


@dataclass(frozen=True)
class Figures(StyleFigures):
    """Measures of a policy's mean action; the fields, with `StyleFigures`', are those of `adaptnet eval --json`.

    Attributes:
        goal_reward: mean goal reward of a step, in (0, 1]; random goals.
        falls_per_minute: episodes that ended by a fall, by getting lost or by diverging, per simulated minute.
        lost_per_minute: those of them that got lost: 3 m farther from the target than when it was drawn.
        targets_reached: share of the targets that the root reached within 0.5 m before their timer or the episode
            ended; None if no target came to its end.
        imitation_error_m: mean distance to the reference [m], straight ahead (see `imitation_error`); None if no world
            stayed up for 3 s.
        imitation_error_std_m: standard deviation over matched frames [m].
        slip_median_cm_s: median sliding speed of the feet's lowest corner; None if no foot touched the ground.
        slip_p90_cm_s: its 90th percentile.
        jerk_ratio: mean jerk of the links over the reference's.
        seconds: simulated seconds, all worlds together.
        seed: of start states and goals.
    """

    goal_reward: float
    falls_per_minute: float
    lost_per_minute: float
    targets_reached: float | None
    imitation_error_m: float | None
    imitation_error_std_m: float | None
    slip_median_cm_s: float | None
    slip_p90_cm_s: float | None
    jerk_ratio: float | None
    seconds: float
    seed: int


@dataclass(frozen=True)
class Evaluation:
    """Figures with the rollouts they were taken from.

    Attributes:
        figures: the measures.
        free: worlds with random goals.
        straight: worlds with the goal held straight ahead.
    """

    figures: Figures
    free: Recording
    straight: Recording


def evaluate(
    policy: Acting, env: AdaptVectorEnv, seconds: float = DEFAULT_SECONDS, seed: int = 0, progress: Progress = iter,
    base: Acting | None = None, speed: float | None = None,
) -> Evaluation:  # fmt: skip
    """Measure a policy's mean action.

    Args:
        policy: acts on observations of all worlds.
        env: worlds without a time limit (`open_worlds`); fallen or lost ones restart and count.
        seconds: simulated seconds with random goals, all worlds together.
        seed: of start states and goals.
        progress: wraps the step numbers of each rollout.
        base: what a style's visibility is compared with; None takes an adaptation's own base.
        speed: preferred speed [m/s] straight ahead; None for the worlds' `reference_speed`.

    Raises:
        ValueError: if `seconds` is less than one step of all worlds.
    """
    steps = round(seconds / env.num_envs / CONTROL_DT)
    if steps < 1:
        raise ValueError(f"seconds is {seconds}, but one step of {env.num_envs} worlds takes {env.num_envs / 30:.2f}")
    free = record(policy, env, steps, seed, progress)
    straight = record_straight(policy, env, speed, seed, progress=progress)
    base_error = tempo_error_of_base(policy, env, seed, progress, base, speed)
    return Evaluation(figures_of(env, free, straight, base_error, seed), free, straight)


def figures_of(
    env: AdaptVectorEnv, free: Recording, straight: Recording, base_error: float | None, seed: int
) -> Figures:
    """Figures of two recordings of the worlds `env`; for `base_error` see `style_figures`."""
    clip = env.worlds.reference.clips[0]
    error = imitation_error(straight, clip, body=env.worlds.reference.model)
    sliding = slips(free, env)
    median, high = np.percentile(sliding, [50, 90]) if len(sliding) else (None, None)
    return Figures(
        **vars(style_figures(env, straight, base_error)),
        goal_reward=rounded(free.rewards.mean()),
        falls_per_minute=rounded(60 * free.restarts.sum() / free.seconds),
        lost_per_minute=rounded(60 * free.ends["lost"] / free.seconds),
        targets_reached=rounded(free.reached / free.targets) if free.targets else None,
        imitation_error_m=rounded(error.mean),
        imitation_error_std_m=rounded(error.std),
        slip_median_cm_s=rounded(median),
        slip_p90_cm_s=rounded(high),
        jerk_ratio=rounded(jerk_ratio(free, clip)),
        seconds=rounded(free.seconds),
        seed=seed,
    )
