"""Checkpoints of a training run, and going on from one."""

import json
import time
from collections.abc import Sequence
from typing import Any

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from sb3_adaptnet.algorithms.model_based import ModelBasedAlgorithm
from sb3_adaptnet.objectives.attribute_ramp import AttributeRamp
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.runs.random_state import random_states, restore_random_states
from sb3_adaptnet.runs.run_folder import RunFolder


class RunSaver(BaseCallback):
    """Saves every few minutes between two rollouts, restores at the start, stops when asked.

    It must stand after the discriminators' callback, whose networks it restores.
    """

    def __init__(
        self,
        folder: RunFolder,
        discriminators: DiscriminatorRewardCallback | None,
        minutes: float = 3.0,
        resume: dict[str, Any] | None = None,
        ramps: Sequence[AttributeRamp] = (),
    ) -> None:
        """Prepare.

        Args:
            folder: where checkpoints go.
            discriminators: the callback whose state belongs to the run, if there is one.
            minutes: time between checkpoints.
            resume: state to go on from.
            ramps: attributes of the worlds that change meanwhile.
        """
        super().__init__()
        self.folder, self.discriminators, self.minutes, self.resume = folder, discriminators, minutes, resume
        self.ramps = ramps
        self.seconds = float(resume["seconds"]) if resume else 0.0
        self._stop = False

    def _init_callback(self) -> None:
        self._clock = time.monotonic()
        self._saved = float("-inf")  # a run that dies early can be resumed as well
        if self.resume is not None:
            restore(self.model, self.discriminators, self.resume, self.ramps)
            self.resume, self._saved = None, self._clock

    def ask_to_stop(self) -> None:
        """End training at the next step of the worlds; may be called from a signal handler."""
        self._stop = True

    def _on_step(self) -> bool:
        return not self._stop

    def _on_rollout_start(self) -> None:
        if time.monotonic() - self._saved > 60.0 * self.minutes:
            self.save()

    def save(self) -> None:
        """Write a checkpoint now."""
        now = time.monotonic()
        self.seconds, self._clock = self.seconds + now - self._clock, now
        self.folder.save(snapshot(self.model, self.discriminators, self.seconds, self.ramps))
        self._saved = time.monotonic()


def snapshot(
    model: BaseAlgorithm,
    discriminators: DiscriminatorRewardCallback | None,
    seconds: float,
    ramps: Sequence[AttributeRamp] = (),
) -> dict[str, Any]:
    """Everything that training changes, as tensors and plain values."""
    learner: Any = model
    state = discriminators.state_dict() if discriminators is not None else {"imitation": None, "rng": None}
    return {
        "samples": model.num_timesteps,
        "updates": learner._n_updates,
        "seconds": seconds,
        "policy": model.policy.state_dict(),
        "optimizer": model.policy.optimizer.state_dict(),
        "imitation": state["imitation"],
        "order": json.dumps(state["rng"]),
        "ramps": [ramp.state_dict() for ramp in ramps],
        "world": model.world_state() if isinstance(model, ModelBasedAlgorithm) else None,
        "random": random_states(),
    }


def restore(
    model: BaseAlgorithm,
    discriminators: DiscriminatorRewardCallback | None,
    state: dict[str, Any],
    ramps: Sequence[AttributeRamp] = (),
) -> None:
    """Put `snapshot`'s state back; the model's callbacks must be initialised."""
    learner: Any = model
    model.policy.load_state_dict(state["policy"])
    model.policy.optimizer.load_state_dict(state["optimizer"])
    model.num_timesteps = int(state["samples"])
    learner._n_updates = int(state["updates"])
    if discriminators is not None:
        discriminators.load_state_dict({"imitation": state["imitation"], "rng": json.loads(state["order"])})
    for ramp, at in zip(ramps, state.get("ramps", ()), strict=False):  # older checkpoints have none
        ramp.load_state_dict(at)
    if isinstance(model, ModelBasedAlgorithm):
        model.set_world_state(state["world"])
    restore_random_states(state["random"])
