"""An algorithm whose policy is a running average of the weights that learn."""

from typing import Any

import torch
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm

from sb3_adaptnet.objectives.weight_average import WeightAverage
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy


class AveragedAlgorithm(BaseAlgorithm):
    """Acts for others, and saves, by the average; a subclass learns within `with weight_average.learning():`."""

    policy: ObjectivePolicy
    _average: WeightAverage | None

    @property
    def weight_average(self) -> WeightAverage:
        """Average of what the policy learns, which the policy holds except while it learns.

        A policy that was given other weights, as by `load_adaptation`, begins a new one.
        """
        weights, average = self._learned_weights(), self._average
        if average is None or not average.watches(weights):
            self._average = average = WeightAverage(weights)
        return average

    def _learned_weights(self) -> list[torch.nn.Parameter]:
        return [parameter for parameter in self.policy.actor.parameters() if parameter.requires_grad]

    def predict(self, *args: Any, **kwargs: Any) -> tuple[NDArray[Any], tuple[NDArray[Any], ...] | None]:
        """Act by the average weights; as in Stable-Baselines3."""
        with self.weight_average.acting():
            return super().predict(*args, **kwargs)

    def save(self, *args: Any, **kwargs: Any) -> None:
        """Save, with the average as the policy; as in Stable-Baselines3."""
        with self.weight_average.acting():
            super().save(*args, **kwargs)

    def _excluded_save_params(self) -> list[str]:
        return [*super()._excluded_save_params(), "_average"]
