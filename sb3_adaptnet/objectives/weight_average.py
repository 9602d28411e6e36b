"""A running average of the learned weights: it acts for others, the latest weights act and learn while learning."""

import operator
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import Any

import torch
from stable_baselines3.common.callbacks import BaseCallback
from torch import nn

from sb3_adaptnet.objectives.schedule import checked_decay


class WeightAverage(nn.Module):
    """Exponential moving average of some parameters (cf. Polyak & Juditsky 1992).

    The parameters themselves hold the average, and this module the latest weights, except `with average.learning():`,
    where they change places. So whoever uses, saves or exports the policy gets the average.

    Attributes:
        updates: () updates that the average has seen; before the first, the average is the latest weights.
    """

    updates: torch.Tensor

    def __init__(self, parameters: Sequence[nn.Parameter]) -> None:
        """Average these parameters, from their first update on."""
        super().__init__()
        self._parameters_of_policy = tuple(parameters)
        self._latest_in_use = False
        self.register_buffer("updates", torch.zeros((), dtype=torch.long))
        for number, parameter in enumerate(parameters):
            self.register_buffer(f"other_{number}", parameter.detach().clone())

    def watches(self, parameters: Sequence[nn.Parameter]) -> bool:
        """Whether it averages these very parameters."""
        own = self._parameters_of_policy
        return len(own) == len(parameters) and all(map(operator.is_, own, parameters))

    def _pairs(self) -> Iterator[tuple[torch.Tensor, torch.Tensor]]:
        for number, parameter in enumerate(self._parameters_of_policy):
            yield parameter.detach(), self.get_buffer(f"other_{number}")

    @contextmanager
    def learning(self) -> Iterator[None]:
        """Put the latest weights into the parameters for a while; afterwards they hold the average again."""
        with self._turned_to(latest=True):
            yield

    @contextmanager
    def acting(self) -> Iterator[None]:
        """Put the average into the parameters for a while, whatever they hold; afterwards they hold that again."""
        with self._turned_to(latest=False):
            yield

    @contextmanager
    def _turned_to(self, *, latest: bool) -> Iterator[None]:
        if latest == self._latest_in_use:
            yield
            return
        self._exchange()
        try:
            yield
        finally:
            self._exchange()

    @torch.no_grad()
    def _exchange(self) -> None:
        self._latest_in_use = not self._latest_in_use
        if self.updates == 0:  # nothing was learned, so that both are the same
            return
        for weights, others in self._pairs():
            kept = weights.clone()
            weights.copy_(others)
            others.copy_(kept)

    @torch.no_grad()
    def update(self, decay: float) -> None:
        """Take in the latest weights, which the parameters must hold; `decay` is what remains of the average."""
        rate = 1.0 if self.updates == 0 else 1.0 - decay
        for weights, average in self._pairs():
            average.lerp_(weights, rate)
        self.updates += 1


class WeightAveraging(BaseCallback):
    """Averages what the actor learns, an update of PPO being one rollout's: the policy is the average in the end.

    Rollouts come from the latest weights and train them; after `learn`, and in checkpoints of runs, the policy holds
    the average, which is steadier than each of them. With the same callback `learn` goes on from the latest weights.
    """

    average: WeightAverage

    def __init__(self, decay: float = 0.98) -> None:
        """Choose the memory.

        Args:
            decay: what a rollout leaves of the average, at least 0 and below 1: 0.98 averages over some 50 rollouts.

        Raises:
            ValueError: for another decay.
        """
        super().__init__()
        self.decay = checked_decay("the decay of an average", decay)
        self._while_learning, self._seen = ExitStack(), 0

    def _init_callback(self) -> None:
        if hasattr(self.model, "weight_average"):
            raise ValueError(f"{type(self.model).__name__} averages its weights by itself, by its average_decay")
        self._watch_policy()

    def _watch_policy(self) -> None:
        policy: Any = self.model.policy
        weights = [weight for weight in getattr(policy, "actor", policy).parameters() if weight.requires_grad]
        if not hasattr(self, "average") or not self.average.watches(weights):
            self.average = WeightAverage(weights)

    def _on_training_start(self) -> None:
        self._seen = self._updates()
        self._while_learning.enter_context(self.average.learning())

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:
        self._take_in()

    def _on_training_end(self) -> None:
        self._take_in()
        self._while_learning.close()

    def _updates(self) -> int:
        learner: Any = self.model
        return int(learner._n_updates)

    def _take_in(self) -> None:
        if self._updates() > self._seen:
            self._seen = self._updates()
            self.average.update(self.decay)

    def state_dict(self) -> dict[str, Any]:
        """The weights that the policy does not hold, for resuming a run; to be taken while it holds the average."""
        return dict(self.average.state_dict())

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Restore what `state_dict` gave, for a policy that holds the average."""
        self._watch_policy()  # restoring may have built its actor anew
        self.average.load_state_dict(state)
