"""How strongly an adaptation acts in a rollout: in part, too, so that half a style steers."""

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext

import numpy as np
from stable_baselines3.common.policies import BasePolicy

from sb3_adaptnet.modules.adaptation.at_alpha import at_alpha
from sb3_adaptnet.objectives.schedule import Schedule
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy

STEPS = 96
"""Control steps at least at one strength: 3.2 s, about as long as a target lasts. All worlds change at once, since the
adaptors are summed with the layers, which is cheap for one strength alone."""


def check_share(policy: type[BasePolicy], share: Schedule) -> None:
    """Refuse to let a policy act in part that cannot.

    Raises:
        ValueError: for a share that is not always 0, unless the policy is an `AdaptNetPolicy`.
    """
    shares = share.values() if isinstance(share, Mapping) else [share]
    if max(shares) > 0 and not issubclass(policy, AdaptNetPolicy):
        raise ValueError(f"a {policy.__name__} has no alpha, which partial_share {share!r} changes; it must be 0")


def strength_at(samples: int, worlds: int, share: float) -> float:
    """The strength of a rollout that begins after so many samples of all worlds.

    It depends on nothing else, so that a run that was stopped goes on by the same strengths.

    Args:
        samples: learned from until now.
        worlds: that act at once.
        share: of the time in which the strength is drawn evenly from 0 to 1; otherwise it is 1.
    """
    in_part, strength = np.random.default_rng(samples // (STEPS * worlds)).random(2)
    return float(strength) if in_part < share else 1.0


def acting_at(policy: BasePolicy, strength: float) -> AbstractContextManager[None]:
    """Scale the policy's alpha by a strength meanwhile; one of 1 changes nothing."""
    if strength == 1 or not isinstance(policy, AdaptNetPolicy):
        return nullcontext()
    return at_alpha(policy, policy.alpha * strength)
