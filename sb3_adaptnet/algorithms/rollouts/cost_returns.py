"""Costs-to-go of real rollouts: TD(lambda) with ends that cost (Sutton & Barto, 2nd ed., ch. 12)."""

import torch


def costs_to_go(
    costs: torch.Tensor,
    values: torch.Tensor,
    ended: torch.Tensor,
    failed: torch.Tensor,
    *,
    discount: float,
    trace: float,
    end_cost: float,
) -> torch.Tensor:
    """What the states after each of T steps of N worlds lead to, the state's own cost not included.

    The states that ended episodes are not known: a failure is a step of no cost to a state whose cost-to-go is
    `end_cost`, and before any other end the critic's own value stands.

    Args:
        costs: (T, N) of the states after the steps.
        values: (T, N) costs-to-go of these states, by the critic.
        ended: (T, N) whether the step ended an episode: the state after it means nothing.
        failed: (T, N) whether it did so by a failure.
        discount: what a cost counts one step later.
        trace: lambda; 1 sums up costs to the end, 0 trusts the critic after one step.
        end_cost: cost-to-go of a failure.

    Returns:
        (T, N), NaN where it is not known: after an end, before one that was no failure, and at the rollout's end.
    """
    found = torch.full_like(costs, torch.nan)
    for step in range(len(costs) - 2, -1, -1):
        after = step + 1
        later = torch.where(found[after].isnan(), values[after], values[after].lerp(found[after], trace))
        going_on = costs[after] + discount * later
        found[step] = torch.where(ended[after], torch.nan, going_on)
        found[step] = torch.where(failed[after], discount * end_cost, found[step])
    return torch.where(ended, torch.nan, found)
