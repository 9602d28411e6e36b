"""Merged adaptors give the same actions."""

import pytest
import torch
from network_cases import (
    SHAPES,
    adapt,
    disturb,
    make_base,
    observation,
    two_adaptations,
)

from sb3_adaptnet.modules.adaptation.merge import merge


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("alpha", [1.0, 0.4])
def test_merged_equals_unmerged(name, alpha):
    actor = adapt(make_base(), SHAPES[name])
    disturb(actor.adaptations)
    actor.alpha = alpha
    merged = merge(actor)
    for ours, theirs in zip(merged(observation()), actor(observation()), strict=True):
        assert torch.allclose(ours, theirs, atol=1e-5)
    assert all(part.adaptors is None for part in merged.parts().values())


def test_blend_merges_too():
    _, actor = two_adaptations()
    actor.blend({"stoop": 0.3, "limp": 0.7})
    assert torch.allclose(merge(actor)(observation())[0], actor(observation())[0], atol=1e-5)
