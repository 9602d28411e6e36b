"""Gradients that are added on the way back, against autograd's."""

import torch

from sb3_adaptnet.modules.layers.regularizers import penalise_injections, penalise_parameters


def test_penalty_gradients_are_exact():
    generator = torch.Generator().manual_seed(0)
    x, y = (torch.randn(9, width, generator=generator, dtype=torch.float64, requires_grad=True) for width in (4, 6))
    norms = torch.linalg.vector_norm(torch.cat((x, y), dim=1), dim=1)
    expected = torch.autograd.grad((x**3).sum() + (y**2).sum() + 0.3 * norms.mean(), (x, y))
    attached = penalise_injections({0: x, 2: y}, 0.3)
    found = torch.autograd.grad((attached[0] ** 3).sum() + (attached[2] ** 2).sum(), (x, y))
    joint = torch.linalg.vector_norm(torch.cat((x.flatten(), y.flatten())))
    expected += torch.autograd.grad((x**3).sum() + (y**2).sum() + 0.3 * joint, (x, y))
    a, b = penalise_parameters([x, y], 0.3)
    found += torch.autograd.grad((a**3).sum() + (b**2).sum(), (x, y))
    for ours, theirs in zip(found, expected, strict=True):
        assert torch.allclose(ours, theirs, atol=1e-12)
