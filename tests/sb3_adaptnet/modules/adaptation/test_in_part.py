"""Each row of a batch acts, and learns, at its own strength as all of them do at that alpha."""

import pytest
import torch
from network_cases import SHAPES, adapt, disturb, gradients, make_base, observation

from sb3_adaptnet.modules.observation import Observation


def loss_of(actor, seen):
    mean, log_std = actor(seen)
    return mean.square().sum() + log_std.sum()


@pytest.mark.parametrize("name", SHAPES)
def test_rows_act_and_learn_as_at_their_own_alpha(name):
    actor, seen = adapt(make_base(), SHAPES[name]), observation()
    disturb(actor.adaptations)
    strengths = torch.tensor([1.0, 0.5, 0.0, 0.25, 1.0, 0.8, 0.1])
    actor.alpha = 0.9
    with actor.at_strengths(strengths), actor.one_update(1):
        mean, _ = actor(seen)
        found = gradients(actor, loss_of(actor, seen))
    losses = []
    for row, strength in enumerate(strengths.tolist()):
        actor.alpha = 0.9 * strength
        alone = Observation(*(None if part is None else part[row : row + 1] for part in seen))
        assert torch.allclose(mean[row : row + 1], actor(alone)[0], atol=1e-5)
        losses.append(loss_of(actor, alone))
    for ours, theirs in zip(found, gradients(actor, sum(losses)), strict=True):
        assert torch.allclose(ours, theirs, rtol=1e-4, atol=1e-5 * float(theirs.abs().max()))


def test_whole_rows_alone_change_nothing():
    actor = adapt(make_base(), SHAPES["adaptnet"])
    with actor.at_strengths(torch.ones(7)):
        assert actor.in_part is None
