"""The heightmap encoder, in both precisions, against torch's convolutions."""

import torch

from sb3_adaptnet.modules.heightmap import HeightmapEncoder


def test_heightmap_encoder_makes_256_numbers():
    code = HeightmapEncoder()(torch.randn(3, 1, 35, 35))
    assert code.shape == (3, 256)


def test_heightmap_codes_that_are_learned_from_are_those_that_act():
    torch.manual_seed(0)
    encoder, heights = HeightmapEncoder(), torch.randn(64, 1, 35, 35)
    learned, theirs = encoder(heights), encoder.layers(heights)
    with torch.no_grad():
        acting = encoder(heights)
    assert (acting > 0).any() and not acting.requires_grad
    torch.testing.assert_close(learned, acting)
    found, wanted = (torch.autograd.grad(code.square().sum(), list(encoder.parameters())) for code in (learned, theirs))
    torch.testing.assert_close(found, wanted)


def test_heightmap_codes_in_bfloat16_are_near_those_in_float32():
    torch.manual_seed(0)
    encoder, heights = HeightmapEncoder(), torch.randn(64, 1, 35, 35)
    exact = encoder.layers(heights)
    with torch.autocast("cpu", torch.bfloat16):
        short = encoder(heights)
    assert short.dtype == torch.bfloat16
    assert (short.float() - exact).abs().max() < 0.02 * exact.abs().max()
    wanted, found = (
        torch.autograd.grad(code.float().square().sum(), list(encoder.parameters())) for code in (exact, short)
    )
    for ours, theirs in zip(found, wanted, strict=True):
        assert torch.nn.functional.cosine_similarity(ours.flatten(), theirs.flatten(), dim=0) > 0.99
