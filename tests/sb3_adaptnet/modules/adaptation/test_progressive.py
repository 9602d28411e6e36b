"""The progressive column beside a frozen base."""

import torch
from network_cases import (
    make_base,
    observation,
)

from sb3_adaptnet.modules.adaptation.progressive import ProgressiveActor


def test_progressive_column_learns_and_reads_the_frozen_base():
    base = make_base()
    actor = ProgressiveActor(base, heightmap=True)
    actor.start_from_base()
    mean, log_std = actor(observation())
    assert torch.equal(log_std, base(observation())[1])
    (mean.square().sum()).backward()
    learning = [p for p in actor.parameters() if p.requires_grad]
    assert all(p.grad is not None for p in learning)
    assert all(p.grad is None for p in base.parameters())
    with torch.no_grad():
        base.encoder.gru.bias_ih_l0.add_(1.0)
    assert not torch.allclose(actor(observation())[0], mean, atol=1e-4)
