"""Checkpoints of a training run, and going on from one."""

import json
import random
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from typing import Any, Protocol, runtime_checkable

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback

from sb3_adaptnet.algorithms.model_based import ModelBasedAlgorithm
from sb3_adaptnet.objectives.callback import DiscriminatorRewardCallback
from sb3_adaptnet.objectives.weight_average import WeightAveraging
from sb3_adaptnet.policies.from_base import PolicyFromBase
from sb3_adaptnet.policies.optimizer_groups import ACTOR, restore_moments
from sb3_adaptnet.runs.run_folder import RunFolder


@runtime_checkable
class Stateful(Protocol):
    """A callback that belongs to a run's checkpoint."""

    def state_dict(self) -> dict[str, Any]:
        """Return all that changes in training, as tensors and plain values."""

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Restore what `state_dict` gave."""


class RunSaver(BaseCallback):
    """Saves every few minutes between two rollouts, restores at the start, stops when asked.

    It must stand after the callbacks that it saves and restores.
    """

    def __init__(
        self,
        folder: RunFolder,
        discriminators: DiscriminatorRewardCallback | None,
        minutes: float = 3.0,
        resume: dict[str, Any] | None = None,
        others: Sequence[Stateful] = (),
    ) -> None:
        """Prepare.

        Args:
            folder: where checkpoints go.
            discriminators: the callback whose state belongs to the run, if there is one.
            minutes: time between checkpoints.
            resume: state to go on from.
            others: further callbacks whose state belongs to the run; each must be initialised before.
        """
        super().__init__()
        self.folder, self.discriminators, self.minutes, self.resume = folder, discriminators, minutes, resume
        self.others = others
        self.seconds = float(resume["seconds"]) if resume else 0.0
        self._stop = False
        self._begun_at: int | None = None  # samples when the present rollout began

    def _init_callback(self) -> None:
        self._clock = time.monotonic()
        self._saved = float("-inf")  # a run that dies early can be resumed as well
        if self.resume is not None:
            restore(self.model, self.discriminators, self.resume, self.others)
            self.resume, self._saved = None, self._clock

    def ask_to_stop(self) -> None:
        """End training at the next step of the worlds; may be called from a signal handler."""
        self._stop = True

    def _on_step(self) -> bool:
        return not self._stop

    def _on_rollout_start(self) -> None:
        self._begun_at = self.model.num_timesteps
        if time.monotonic() - self._saved > 60.0 * self.minutes:
            self.save()

    def _on_rollout_end(self) -> None:
        self._begun_at = None

    def save(self) -> None:
        """Write a checkpoint now. A rollout that was cut short does not count: nothing was learned from it."""
        if self._begun_at is not None:
            self.model.num_timesteps = self._begun_at
        now = time.monotonic()
        self.seconds, self._clock = self.seconds + now - self._clock, now
        self.folder.save(snapshot(self.model, self.discriminators, self.seconds, self.others))
        self._saved = time.monotonic()


def snapshot(
    model: BaseAlgorithm,
    discriminators: DiscriminatorRewardCallback | None,
    seconds: float,
    others: Sequence[Stateful] = (),
) -> dict[str, Any]:
    """Everything that training changes, as tensors and plain values; the policy holds averaged weights."""
    with ExitStack() as averaged:
        for callback in others:
            if isinstance(callback, WeightAveraging):
                averaged.enter_context(callback.average.acting())
        return _snapshot(model, discriminators, seconds, others)


def _snapshot(
    model: BaseAlgorithm, discriminators: DiscriminatorRewardCallback | None, seconds: float, others: Sequence[Stateful]
) -> dict[str, Any]:
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
        "callbacks": {name: callback.state_dict() for name, callback in _named(others)},
        "world": model.world_state() if isinstance(model, ModelBasedAlgorithm) else None,
        "random": random_states(),
    }


def _networks(policy: Any) -> dict[str, Any]:
    """What the networks of a policy are made of, whatever its base is called."""
    description = policy.describe()
    return {name: value for name, value in description["actor"].items() if name != "base"} | {
        "critic": description["critic"]
    }


def restore(
    model: BaseAlgorithm,
    discriminators: DiscriminatorRewardCallback | None,
    state: dict[str, Any],
    others: Sequence[Stateful] = (),
) -> None:
    """Put `snapshot`'s state back; the model's callbacks must be initialised.

    Settings stay the model's: step sizes that the training does not set itself may have changed since.

    Raises:
        ValueError: if the model's networks are of another shape.
    """
    learner: Any = model
    own = _networks(model.policy)
    guessed = isinstance(model.policy, PolicyFromBase) and model.policy.lacks_files
    model.policy.load_state_dict(state["policy"])
    if (found := _networks(model.policy)) != own and not guessed:
        name = next(name for name in found if found[name] != own.get(name))
        raise ValueError(f"config.yml changes the policy's networks, which a run keeps: {name} was {found[name]}")
    steered = (ACTOR,) if discriminators is not None and discriminators.kl_range is not None else ()
    restore_moments(model.policy.optimizer, state["optimizer"], steered)
    model.num_timesteps = int(state["samples"])
    learner._n_updates = int(state["updates"])
    if discriminators is not None:
        discriminators.load_state_dict({"imitation": state["imitation"], "rng": json.loads(state["order"])})
    kept = state.get("callbacks", {})
    for name, callback in _named(others):
        if name in kept:  # older checkpoints have none, and `config.yml` may have got more
            callback.load_state_dict(kept[name])
    if isinstance(model, ModelBasedAlgorithm):
        model.set_world_state(state["world"])
    restore_random_states(state["random"])


def _named(callbacks: Sequence[Stateful]) -> Iterator[tuple[str, Stateful]]:
    """Callbacks by class and number among their like."""
    of_class = Counter[str]()
    for callback in callbacks:
        name = type(callback).__name__
        yield f"{name} {of_class[name]}", callback
        of_class[name] += 1


def random_states() -> dict[str, Any]:
    """Read all global random states, in a form that `torch.load(weights_only=True)` accepts."""
    name, keys, position, has_gauss, cached = np.random.get_state(legacy=True)
    return {
        "python": json.dumps(random.getstate()),
        "numpy": json.dumps([name, np.asarray(keys).tolist(), position, has_gauss, cached]),
        "torch": torch.get_rng_state(),
        "cuda": torch.cuda.get_rng_state_all() if torch.cuda.is_available() else [],
    }


def restore_random_states(states: dict[str, Any]) -> None:
    """Set all global random states to what `random_states` gave."""
    version, internal, gauss = json.loads(states["python"])
    random.setstate((version, tuple(internal), gauss))
    name, keys, position, has_gauss, cached = json.loads(states["numpy"])
    np.random.set_state((name, np.array(keys, np.uint32), position, has_gauss, cached))
    torch.set_rng_state(states["torch"].cpu())
    if states["cuda"] and torch.cuda.is_available():
        torch.cuda.set_rng_state_all([state.cpu() for state in states["cuda"]])
