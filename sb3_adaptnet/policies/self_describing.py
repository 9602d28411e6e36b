"""State dicts that describe the networks they belong to, so that whoever loads one can rebuild the networks first.

The description is JSON in a uint8 tensor, because `torch.load(weights_only=True)` takes tensors without question.
"""

import json
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import torch
from torch import nn

KEY = "_extra_state"
"""Under which torch puts into a state dict what `get_extra_state` returns."""


def pack(description: Mapping[str, Any]) -> torch.Tensor:
    """A description as a tensor (bytes,) uint8; equal descriptions give equal tensors."""
    return torch.frombuffer(bytearray(json.dumps(description, sort_keys=True).encode()), dtype=torch.uint8)


def unpack(packed: torch.Tensor) -> dict[str, Any]:
    """The description in a tensor that `pack` made; tuples have become lists."""
    return json.loads(bytes(packed.cpu().tolist()))


class SelfDescribing(nn.Module):
    """A module whose state dict carries its description: loading one first rebuilds the module, then fills it."""

    @abstractmethod
    def describe(self) -> dict[str, Any]:
        """JSON values from which `become` makes networks of the same shape, and all that is no tensor."""

    @abstractmethod
    def become(self, description: Mapping[str, Any]) -> None:
        """Rebuild what differs from a description; the weights are about to be loaded."""

    def get_extra_state(self) -> torch.Tensor:
        """The description, as part of the state dict."""
        return pack(self.describe())

    def set_extra_state(self, state: torch.Tensor) -> None:
        """Nothing: `load_state_dict` has read the description before it loads the weights."""

    def load_state_dict(self, state_dict: Mapping[str, Any], strict: bool = True, assign: bool = False) -> Any:
        """Load weights, after `become` where the state is described."""
        if KEY in state_dict:
            self.become(unpack(state_dict[KEY]))
        return super().load_state_dict(state_dict, strict=strict, assign=assign)
