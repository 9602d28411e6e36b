"""The anchor's penalty against the same penalty in the loss."""

import torch
from network_cases import (
    SMALL,
    disturb,
    gradients,
    loss_of,
    make_base,
    observation,
)

from sb3_adaptnet.modules.adaptation.anchored import AnchoredActor
from sb3_adaptnet.modules.backbone import Backbone


def test_anchor_penalty_equals_an_explicit_loss():
    base = make_base()
    network = Backbone(SMALL)
    network.load_state_dict(base.state_dict())
    network.log_std.requires_grad_(False)
    actor = AnchoredActor(network, base, kappa=0.2)
    disturb(network)
    known = dict(base.named_parameters())
    drift = [p - known[name] for name, p in network.named_parameters() if p.requires_grad]
    distance = torch.linalg.vector_norm(torch.cat([d.flatten() for d in drift]))
    expected = torch.autograd.grad(
        loss_of(network, observation()) + 0.2 * distance, [p for p in network.parameters() if p.requires_grad]
    )
    found = gradients(actor, loss_of(actor, observation()))
    for ours, theirs in zip(found, expected, strict=True):
        assert torch.allclose(ours, theirs, atol=1e-7, rtol=1e-5)


def test_anchor_penalty_at_the_anchor_is_zero():
    base = make_base()
    network = Backbone(SMALL)
    network.load_state_dict(base.state_dict())
    network.log_std.requires_grad_(False)
    plain = gradients(network, loss_of(network, observation()))
    anchored = AnchoredActor(network, base, kappa=3.0)
    found = gradients(anchored, loss_of(anchored, observation()))
    assert all(torch.equal(ours, theirs) for ours, theirs in zip(found, plain, strict=True))
