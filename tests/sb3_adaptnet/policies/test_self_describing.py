"""State dicts that say what they belong to."""

import torch
from torch import nn

from sb3_adaptnet.policies.self_describing import KEY, SelfDescribing, pack, unpack


class Wide(SelfDescribing):
    """A layer of any width."""

    def __init__(self, width):
        super().__init__()
        self.layer = nn.Linear(width, 1)

    def describe(self):
        return {"width": self.layer.in_features}

    def become(self, description):
        self.layer = nn.Linear(description["width"], 1)


def test_a_module_becomes_what_the_state_describes():
    first, second = Wide(3), Wide(5)
    second.load_state_dict(first.state_dict())
    assert torch.equal(second.layer.weight, first.layer.weight)
    second.load_state_dict({name: t for name, t in first.state_dict().items() if name != KEY}, strict=False)


def test_descriptions_are_plain_bytes_that_come_back(tmp_path):
    description = {"b": (1, 2.5), "a": {"name": "walk", "none": None}}
    packed = pack(description)
    torch.save(packed, tmp_path / "packed")
    again = unpack(torch.load(tmp_path / "packed", weights_only=True))
    assert packed.dtype == torch.uint8 and again == {"a": {"name": "walk", "none": None}, "b": [1, 2.5]}
    assert torch.equal(packed, pack(dict(reversed(description.items()))))
