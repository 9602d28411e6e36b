"""A warning for rollouts that are too long: a policy cannot see PPO's n_steps before."""

import warnings

LONGEST_ROLLOUT = 65_536
"""Samples; beyond this an update is rare and its buffer takes gigabytes."""


class RolloutLength:
    """Counts the samples since the last update, and warns once per rollout that it is long."""

    def __init__(self) -> None:
        """Begin before the first sample."""
        self.samples = 0

    def add(self, samples: int) -> None:
        """Count samples that were collected."""
        before, self.samples = self.samples, self.samples + samples
        if before <= LONGEST_ROLLOUT < self.samples:
            warnings.warn(
                f"more than {LONGEST_ROLLOUT:,} samples without an update: PPO's n_steps x number of environments is "
                f"large; hyperparameters(id) has values that suit many environments, such as n_steps=8 for 256",
                stacklevel=3,
            )

    def start_again(self) -> None:
        """Begin a new rollout."""
        self.samples = 0
