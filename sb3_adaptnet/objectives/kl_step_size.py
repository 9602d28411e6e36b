"""Keeps the KL divergence of an update within a range, by the actor's step size."""

import math

from sb3_adaptnet.objectives.schedule import Schedule, check_number, check_schedule, times_of, value_at

KlRange = tuple[Schedule, Schedule]
"""The smallest and largest KL divergence of an update [nats], each a number or samples -> number."""
KL_RANGE: KlRange = (0.012, 0.03)
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


def kl_range_at(kl_range: KlRange, samples: int) -> tuple[float, float]:
    """The range [nats] after `samples` samples."""
    low, high = kl_range
    return value_at(low, samples), value_at(high, samples)


def check_steps(kl_range: KlRange | None, lr_range: tuple[float, float]) -> None:
    """Refuse ranges of the KL divergence, where there is one, and of the learning rate that cannot be.

    Raises:
        ValueError: naming the range.
    """
    if kl_range is not None:
        check_kl_range(kl_range)
    for bound in lr_range:
        check_number("each bound of actor_lr_range", bound)
    if not 0.0 < lr_range[0] <= lr_range[1]:
        raise ValueError(f"actor_lr_range must be two ascending positive numbers, not {lr_range}")


def check_kl_range(kl_range: KlRange) -> None:
    """Refuse anything but two schedules that are positive and ascending wherever one of them bends.

    Raises:
        ValueError: naming the range.
    """
    for bound in kl_range:
        check_schedule("each bound of kl_range", bound)
    for samples in sorted({*times_of(kl_range[0]), *times_of(kl_range[1])}):
        low, high = kl_range_at(kl_range, samples)
        if not 0.0 < low <= high:
            raise ValueError(f"kl_range must be two ascending positive numbers, not {(low, high)} at {samples} samples")
