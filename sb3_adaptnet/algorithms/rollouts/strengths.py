"""How strongly an adaptation acts in a rollout: in part, too, so that half a style steers."""

from contextlib import AbstractContextManager, nullcontext

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.policies import BasePolicy

from sb3_adaptnet.objectives.schedule import Schedule, highest
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy

STEPS = 96
"""Control steps at least at one strength: 3.2 s, about as long as a target lasts."""


def check_share(policy: type[BasePolicy], share: Schedule) -> None:
    """Refuse to let a policy act in part that cannot.

    Raises:
        ValueError: for a share that is not always 0, unless the policy is an `AdaptNetPolicy`.
    """
    if highest(share) > 0 and not issubclass(policy, AdaptNetPolicy):
        raise ValueError(f"a {policy.__name__} has no alpha, which partial_share {share!r} changes; it must be 0")


def strengths_at(samples: int, worlds: int, share: float) -> NDArray[np.float32]:
    """The strengths (N,) of a rollout that begins after so many samples of all worlds.

    They depend on nothing else, so that a run that was stopped goes on by the same ones.

    Args:
        samples: learned from until now.
        worlds: N that act at once.
        share: of the time in which a world's strength is drawn evenly from 0 to 1; otherwise it is 1.
    """
    in_part, strengths = np.random.default_rng(samples // (STEPS * worlds)).random((2, worlds), np.float32)
    return np.where(in_part < share, strengths, np.float32(1))


def acting_at(policy: BasePolicy, strengths: NDArray[np.float32]) -> AbstractContextManager[None]:
    """Let the adaptation act at a strength (N,) in each world, a factor on alpha; other policies have none."""
    if not isinstance(policy, AdaptNetPolicy) or (strengths == 1).all():  # the usual case needs no transfer
        return nullcontext()
    return policy.actor.at_strengths(torch.as_tensor(strengths, device=policy.device))
