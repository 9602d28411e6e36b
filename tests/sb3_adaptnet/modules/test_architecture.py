"""Shapes of adaptations that cannot be."""

import pytest
from network_cases import (
    SMALL,
)

from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.architecture import AdaptationShape


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"adaptors": "half"}, "full.*lora"),
        ({"rank": 0}, "at least 1"),
        ({"injector": False, "heightmap": True}, "injector"),
    ],
)
def test_impossible_shapes_are_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        AdaptationShape(**wrong)


def test_unknown_injection_lists_the_latent_spaces():
    with pytest.raises(ValueError, match=r"z0.*z1.*z2.*all.*z7"):
        Adaptation(SMALL, AdaptationShape(injection="z7"))
