"""A running average of the learned weights: it acts for others, the latest weights act and learn while learning."""

import operator
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import torch
from torch import nn


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
