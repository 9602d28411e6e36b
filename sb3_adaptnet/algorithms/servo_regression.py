"""A first guess: the policy learns by heart which actions' servos would follow the motion.

It cannot walk by them, but gradients through the model then start near the style instead of far from it.
"""

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.world_model.fitting.collecting import Act

BATCH = 256
"""Poses per update."""
LEARNING_RATE = 5e-4
"""Adam's."""
NOISE, NOISY_SHARE = 0.1, 0.7
"""Noise on the poses, in standard deviations of the motion's own numbers, and the share of poses that get any."""
AHEAD = 0.4
"""Standard deviation [rad] of the directions of half of the goals; the other half lie anywhere."""
SECONDS = 5.0
"""Goals are at most so many seconds away."""


def regress_to_servo_aims(
    policy: ObjectivePolicy,
    motion: TrackedMotion,
    speeds: NDArray[np.floating],
    updates: int,
    rng: np.random.Generator,
) -> float:
    """Fit the policy's mean actions to the motion's servo aims, whatever the goal.

    Args:
        policy: its actor learns.
        motion: the motion.
        speeds: (n,) preferred speeds [m/s] to choose from.
        updates: gradient steps.
        rng: source of randomness.

    Returns:
        The last update's mean squared error of actions.
    """
    parameters = [p for p in policy.actor.parameters() if p.requires_grad]
    optimizer = torch.optim.Adam(parameters, lr=LEARNING_RATE)
    spread, loss = NOISE * motion.frames.std(0), torch.zeros(())
    for _ in range(updates):
        wanted = rng.choice(speeds, BATCH)
        phases = motion.gaits.at_speeds(rng.integers(len(motion), size=BATCH), wanted)
        body, goal = motion.frames[phases], _goals(wanted, rng)
        noise = rng.standard_normal(body.shape) * (rng.random((BATCH, 1)) < NOISY_SHARE)
        body = body + spread * torch.as_tensor(noise, dtype=body.dtype, device=body.device)
        observations = torch.cat((body, torch.as_tensor(goal, dtype=body.dtype, device=body.device)), dim=1)
        with policy.actor.one_update(1):
            loss = (policy.get_distribution(observations).mode() - motion.aims[phases]).square().mean()
            optimizer.zero_grad()
            loss.backward()
        optimizer.step()
    return float(loss.detach())


def _goals(speeds: NDArray[np.floating], rng: np.random.Generator) -> NDArray[np.floating]:
    """Goals (n, 4) as observed, at the given speeds (n,): half of them ahead, half anywhere."""
    n = len(speeds)
    ahead, anywhere = AHEAD * rng.standard_normal(n), rng.uniform(-np.pi, np.pi, n)
    angle = np.where(rng.random(n) < 0.5, ahead, anywhere)
    return np.stack([np.cos(angle), np.sin(angle), SECONDS * speeds * rng.random(n), speeds], axis=1)


def servo_aims(motion: TrackedMotion) -> Act:
    """In place of a policy: servos aim where they would follow the motion. Characters stumble and fall by it."""
    aims = motion.aims.cpu().numpy()

    def act(observations: Any) -> NDArray[np.float32]:
        return np.asarray(aims[motion.nearest(motion.seen_in(observations))])

    return act
