"""The optimiser's two groups of parameters, the actor's and the critic's, each with its own step size.

`PPO` overwrites `lr` of every group before each update. So a group carries an `lr_scale`, which `ScaledAdam` multiplies
`lr` by: the step size of a group is `lr * lr_scale`.
"""

from collections.abc import Container, Mapping
from typing import Any

import torch
from torch import nn

ACTOR, CRITIC = "actor", "critic"
"""Names of the groups."""


def make_groups(
    networks: Mapping[str, nn.Module], step_sizes: Mapping[str, float | None], learning_rate: float
) -> list[dict[str, Any]]:
    """One group per network, with the parameters that learn.

    Args:
        networks: name -> network.
        step_sizes: name -> step size at the start; None takes `learning_rate`.
        learning_rate: PPO's learning rate at the start, which the scales are relative to; 0 where nothing is to learn.

    Returns:
        Groups for an optimiser: name, params, lr_scale.
    """
    groups: list[dict[str, Any]] = []
    for name, network in networks.items():
        step_size = step_sizes[name]
        scale = 1.0 if step_size is None or learning_rate == 0 else step_size / learning_rate
        groups.append({"name": name, "params": [p for p in network.parameters() if p.requires_grad], "lr_scale": scale})
    return groups


def restore_moments(optimizer: torch.optim.Optimizer, state: Mapping[str, Any], steered: Container[str] = ()) -> None:
    """Restore what an optimiser has gathered; step sizes and other settings stay its own, as they may be new.

    Args:
        optimizer: of the same parameters.
        state: its `state_dict` as it was.
        steered: names of groups whose step size the training itself sets: it is restored, too.
    """
    settings = [{key: value for key, value in group.items() if key != "params"} for group in optimizer.param_groups]
    optimizer.load_state_dict(dict(state))
    for group, own in zip(optimizer.param_groups, settings, strict=True):
        size, scale = group["lr"], group.get("lr_scale")
        group.update(own)
        if group.get("name") in steered:
            group["lr_scale"] = scale if size == group["lr"] else size * scale / group["lr"]


def keep_moments(optimizer: torch.optim.Optimizer, before: torch.optim.Optimizer) -> None:
    """Let an optimiser go on with what another one gathered for the same parameters, and with its step sizes.

    Args:
        optimizer: new, with groups of the same names.
        before: the other one.
    """
    for group in optimizer.param_groups:
        old = group_named(before, group["name"])
        group.update({key: old[key] for key in ("lr", "lr_scale") if key in old})
        for parameter in group["params"]:
            if parameter in before.state:
                optimizer.state[parameter] = before.state[parameter]


def group_named(optimizer: torch.optim.Optimizer, name: str) -> dict[str, Any]:
    """The parameter group called `name`.

    Raises:
        KeyError: if there is no such group; the message lists the names there are.
    """
    for group in optimizer.param_groups:
        if group.get("name") == name:
            return group
    names = ", ".join(str(group.get("name")) for group in optimizer.param_groups)
    raise KeyError(f"no parameter group {name!r}; the optimiser has: {names}")


def step_size(optimizer: torch.optim.Optimizer, name: str) -> float:
    """The step size of a group, per update."""
    group = group_named(optimizer, name)
    return group["lr"] * group["lr_scale"]


def set_step_size(optimizer: torch.optim.Optimizer, name: str, size: float) -> None:
    """Give a group a step size, at the present `lr`."""
    group = group_named(optimizer, name)
    group["lr_scale"] = size / group["lr"]
