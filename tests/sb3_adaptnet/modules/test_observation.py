"""Where frames, goal and heightmap stand in an observation."""

import numpy as np
import pytest
import torch
from network_cases import JOINTS

from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.observation import parts_of, read_observation, split_observation, whole_of


def test_observation_index_is_frame_major_then_goal():
    flat = torch.arange(784.0).repeat(2, 1)
    parts = split_observation(flat, Architecture(JOINTS))
    assert parts.frames.shape == (2, 4, 195)
    assert parts.frames[0, 3, 14 * 13 + 12] == (3 * 15 + 14) * 13 + 12
    assert parts.goal[1].tolist() == [780.0, 781.0, 782.0, 783.0]


def test_observation_of_another_width_is_refused():
    with pytest.raises(ValueError, match="783.*784"):
        split_observation(torch.zeros(1, 783), Architecture(JOINTS))


def test_a_dict_and_a_flat_tensor_read_the_same():
    flat, heights = torch.randn(2, 784), torch.randn(2, 1, 35, 35).double()
    alone = read_observation(flat, Architecture(JOINTS))
    code = torch.randn(2, 8)
    parts = {"observation": flat, "heightmap": heights, "base_code": code}
    together = read_observation(parts, Architecture(JOINTS))
    assert torch.equal(alone.frames, together.frames) and torch.equal(alone.goal, together.goal)
    assert alone.heightmap is None and alone.base_code is None
    assert torch.equal(together.heightmap, heights.float()) and together.base_code is code


@pytest.mark.parametrize("whole", [np.zeros(3), {"observation": 1, "heightmap": 2}], ids=["flat", "dict"])
def test_parts_make_up_the_whole_again(whole):
    assert set(parts_of(whole)) <= {"observation", "heightmap"}
    again = whole_of(parts_of(whole))
    assert again is whole or again == whole
