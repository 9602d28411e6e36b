"""One adaptation at several strengths: the interpolation of the paper's sec. 8.1, as clips to draw."""

from collections.abc import Sequence

from adapt_envs import AdaptVectorEnv
from adapt_envs.motion.clip import MotionClip
from sb3_adaptnet.evaluation.figures import reference_speed
from sb3_adaptnet.evaluation.recording import record_straight
from sb3_adaptnet.evaluation.rollout_clips import typical_clip
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy

ALPHAS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Strengths that are drawn beside each other."""


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
    before, reference = policy.alpha, env.worlds.reference.clips[0]
    clips = {}
    for alpha in alphas:
        policy.alpha = alpha
        recording = record_straight(policy, env, reference_speed(env), seed, seconds)
        clips[f"alpha = {alpha:g}"] = typical_clip(recording, reference, f"alpha {alpha:g}")
    policy.alpha = before
    return clips
