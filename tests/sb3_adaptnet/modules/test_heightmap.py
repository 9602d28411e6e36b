"""The heightmap encoder, in both precisions."""

import torch

from sb3_adaptnet.modules.heightmap import HeightmapEncoder


def test_heightmap_encoder_makes_256_numbers():
    code = HeightmapEncoder()(torch.randn(3, 1, 35, 35))
    assert code.shape == (3, 256)


def test_heightmap_codes_in_bfloat16_are_near_those_in_float32():
    torch.manual_seed(0)
    encoder, heights = HeightmapEncoder(), torch.randn(64, 1, 35, 35)
    exact = encoder(heights)
    with torch.autocast("cpu", torch.bfloat16):
        short = encoder(heights)
    assert short.dtype == torch.bfloat16
    assert (short.float() - exact).abs().max() < 0.02 * exact.abs().max()
    wanted, found = (
        torch.autograd.grad(code.float().square().sum(), list(encoder.parameters())) for code in (exact, short)
    )
    for ours, theirs in zip(found, wanted, strict=True):
        assert torch.nn.functional.cosine_similarity(ours.flatten(), theirs.flatten(), dim=0) > 0.99
