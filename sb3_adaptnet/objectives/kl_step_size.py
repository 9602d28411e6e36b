"""Keeps the KL divergence of an update within a range, by the actor's step size."""

import math

KL_RANGE = (0.012, 0.03)
"""Range of the KL divergence per update [nats], measured to learn fast without breaking the policy."""
SCALE_STEP = 1.5
"""Factor of one correction of the step size."""


def next_step_size(
    learning_rate: float, kl: float, kl_range: tuple[float, float], bounds: tuple[float, float]
) -> float:
    """Return the actor's next learning rate.

    Args:
        learning_rate: the one in use.
        kl: KL divergence of the last update, in nats; not finite counts as too large.
        kl_range: below the first the step size grows by 1.5, above the second it shrinks by 1.5.
        bounds: smallest and largest learning rate.

    Returns:
        Learning rate within `bounds`.
    """
    low, high = kl_range
    if not math.isfinite(kl) or kl > high:
        learning_rate /= SCALE_STEP
    elif kl < low:
        learning_rate *= SCALE_STEP
    return min(max(learning_rate, bounds[0]), bounds[1])
