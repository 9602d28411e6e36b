"""PopArt: statistics move, real outputs stay."""

import pytest
import torch

from sb3_adaptnet.modules.layers.popart import PopArtHead


@pytest.mark.parametrize("objectives", [1, 2, 3])
def test_popart_update_preserves_real_outputs_and_normalises_returns(objectives):
    torch.manual_seed(objectives)
    head = PopArtHead(10, objectives).double()
    latent = torch.randn(20, 10, dtype=torch.float64)
    head.linear.double()
    for scale in (1.0, 40.0, 0.3):
        before = head.denormalize(head.linear(latent))
        returns = torch.randn(500, objectives, dtype=torch.float64) * scale + 7 * scale
        head.update(returns)
        assert torch.allclose(head.denormalize(head.linear(latent)), before, atol=1e-9)
    head = PopArtHead(10, objectives)
    head.update(returns.float())
    normalized = head.normalize(returns.float())
    assert torch.allclose(normalized.mean(0), torch.zeros(objectives), atol=1e-4)
    assert torch.allclose(normalized.std(0), torch.ones(objectives), atol=1e-2)
    assert torch.allclose(head.denormalize(normalized), returns.float(), atol=1e-4)


def test_popart_is_the_identity_before_the_first_update():
    head = PopArtHead(4, 2)
    values = torch.randn(3, 2)
    assert torch.equal(head.denormalize(values), values)
    assert torch.equal(head.normalize(values), values)


def test_popart_refuses_other_columns():
    with pytest.raises(ValueError, match=r"\(M, 2\)"):
        PopArtHead(4, 2).update(torch.zeros(5, 3))
