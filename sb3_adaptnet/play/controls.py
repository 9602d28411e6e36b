"""What a person at a window or a browser sets while a policy plays, and the loop that obeys."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from adapt_envs import AdaptVectorEnv
from sb3_adaptnet.policies.adaptnet import TRAINED, AdaptNetPolicy
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy


@dataclass
class Controls:
    """The present wishes; other threads may change them at any time.

    Attributes:
        speed: preferred speed [m/s].
        heading: direction to go, world [rad].
        random_goals: whether goals are sampled at random, as in training, instead.
        alpha: strength of the adaptation; None for a policy that has none.
        weights: weight of each adaptation by name; empty for a policy that has none.
        restart: whether to start again at the next step.
        labels: what to call adaptations whose name says nothing, by name.
    """

    speed: float = 1.2
    heading: float = 0.0
    random_goals: bool = False
    alpha: float | None = None
    weights: dict[str, float] = field(default_factory=dict)
    restart: bool = False
    labels: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, policy: ObjectivePolicy, env: AdaptVectorEnv, style: str = TRAINED) -> "Controls":
        """The controls a policy starts with: its own alpha and weights, the middle of the environment's speeds.

        `style` is what to call the policy's own adaptation.
        """
        low, high = env.worlds.spec.speed_range or (1.0, 1.5)
        if not isinstance(policy, AdaptNetPolicy):
            return cls(speed=(low + high) / 2)
        labels = {TRAINED: style}
        return cls(speed=(low + high) / 2, alpha=policy.alpha, weights=policy.weights, labels=labels)


class View(Protocol):
    """Something that shows a world."""

    @property
    def running(self) -> bool:
        """Whether the person still looks."""

    def show(self) -> None:
        """Show the present state of the first of its worlds, in real time."""

    def close(self) -> None:
        """Free what it holds."""


def apply(controls: Controls, policy: ObjectivePolicy, env: AdaptVectorEnv) -> None:
    """Hand the controls on to policy and worlds."""
    if isinstance(policy, AdaptNetPolicy):
        if controls.alpha is not None and controls.alpha != policy.alpha:
            policy.alpha = controls.alpha
        if controls.weights and controls.weights != policy.weights:
            policy.blend(dict(controls.weights))
    held = bool(np.isfinite(env.worlds.goals.held_heading[0]))
    if not controls.random_goals:
        env.set_goal(controls.heading, controls.speed)
    elif held:
        env.set_goal(None, None)


def play(
    policy: ObjectivePolicy, env: AdaptVectorEnv, view: View, controls: Controls,
    steps: int | None = None, seed: int = 0,
) -> int:  # fmt: skip
    """Run the policy's mean action in one world until the view is closed or `steps` are done; return the steps."""
    observations, _ = env.reset(seed=seed)
    count = 0
    while view.running and (steps is None or count < steps):
        if controls.restart:
            controls.restart = False
            observations, _ = env.reset()
        apply(controls, policy, env)
        actions, _ = policy.predict(observations, deterministic=True)
        observations = env.step(actions)[0]
        view.show()
        count += 1
    return count


def weights_between(names: Mapping[str, float], position: float) -> dict[str, float]:
    """Weights of a blend that glides through the styles in turn: position 0 is the first alone, 0.5 halfway on."""
    last = len(names) - 1
    place = min(max(position, 0.0), float(last))
    return {name: max(0.0, 1.0 - abs(place - i)) for i, name in enumerate(names)}
