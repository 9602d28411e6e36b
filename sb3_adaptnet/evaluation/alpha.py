"""One adaptation at several strengths: the interpolation of the paper's sec. 8.1, as clips to draw."""

from collections.abc import Sequence

from adapt_envs import AdaptVectorEnv
from adapt_envs.motion.clip import MotionClip
from adapt_envs.progress import Progress
from sb3_adaptnet.evaluation.recording import Acting, Recording, record_straight
from sb3_adaptnet.evaluation.rollout_clips import typical_clip
from sb3_adaptnet.modules.adaptation.at_alpha import at_alpha
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy

ALPHAS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Strengths that are drawn beside each other."""


def record_base(
    policy: Acting, env: AdaptVectorEnv, seed: int, progress: Progress = iter, base: Acting | None = None,
    speed: float | None = None,
) -> Recording | None:  # fmt: skip
    """The base going straight ahead; None if there is none: neither a given one nor an adaptation's own.

    Args:
        policy: an adaptation whose own base is meant, unless it is merged.
        env: worlds without a time limit.
        seed: of the start states.
        progress: wraps the step numbers.
        base: another base.
        speed: preferred speed [m/s]; None for the worlds' `reference_speed`.
    """
    if base is not None:
        return record_straight(base, env, speed, seed, progress=progress)
    if not isinstance(policy, AdaptNetPolicy) or policy.merged:
        return None
    with at_alpha(policy, 0.0):
        return record_straight(policy, env, speed, seed, progress=progress)


def alpha_clips(
    policy: AdaptNetPolicy, env: AdaptVectorEnv, alphas: Sequence[float] = ALPHAS, seed: int = 0, seconds: float = 6.0
) -> dict[str, MotionClip]:
    """Straight rollouts at each alpha from the same start states, by caption; the policy keeps its alpha.

    Args:
        policy: an adaptation.
        env: worlds without a time limit (`open_worlds`).
        alphas: strengths.
        seed: of the start states.
        seconds: simulated seconds of each world.
    """
    reference, joints, clips = env.worlds.reference.clips[0], env.worlds.reference.joint_names, {}
    for alpha in alphas:
        with at_alpha(policy, alpha):
            recording = record_straight(policy, env, None, seed, seconds)
        clips[f"alpha = {alpha:g}"] = typical_clip(recording, reference, joints, f"alpha {alpha:g}")
    return clips
