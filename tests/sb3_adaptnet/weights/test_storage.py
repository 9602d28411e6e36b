"""Numbers of a weights file, stored in 32, 16 or 8 bits."""

import pytest
import torch

from sb3_adaptnet.weights.checkpoint import read_base, save_base
from sb3_adaptnet.weights.storage import restored, stored


@pytest.fixture
def tensors() -> dict[str, torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    return {
        "matrix": torch.randn(40, 30, generator=generator) * torch.logspace(-3, 2, 40)[:, None],
        "convolution": torch.randn(6, 2, 3, 3, generator=generator),
        "bias": torch.randn(40, generator=generator),
        "count": torch.tensor(3.0, dtype=torch.float64),
    }


def test_32_bits_are_the_same(tensors):
    assert all(torch.equal(tensor, tensors[name]) for name, tensor in restored(stored(tensors, 32)).items())


def test_a_byte_is_off_by_half_a_step_of_its_row(tensors):
    found = restored(stored(tensors, 8))
    assert found.keys() == tensors.keys()
    for name in ("matrix", "convolution"):
        assert found[name].dtype == torch.float32
        largest = tensors[name].flatten(1).abs().amax(1, keepdim=True)
        off = (found[name] - tensors[name]).flatten(1).abs()
        assert (off <= largest / 254 * (1 + 1e-5)).all()
        assert off.max() > 0
    assert torch.equal(found["bias"], tensors["bias"].half())
    assert torch.equal(found["count"], tensors["count"])


def test_rows_of_zeros_stay_zero():
    assert torch.equal(restored(stored({"w": torch.zeros(3, 4)}, 8))["w"], torch.zeros(3, 4))


def test_what_cannot_be_stored_is_refused(tensors):
    with pytest.raises(ValueError, match="bits must be one of 32, 16, 8, not 4"):
        stored(tensors, 4)
    with pytest.raises(ValueError, match="w has numbers that are not finite, which 8 bits cannot hold"):
        stored({"w": torch.tensor([[1.0, torch.inf]])}, 8)


def test_eight_bits_take_less_room_and_act_nearly_the_same(base_model, base_file, tmp_path):
    byte = save_base(base_model, tmp_path / "byte", bits=8)
    assert byte.stat().st_size < 0.45 * base_file.stat().st_size  # the card counts, too: the network is small
    found, whole = (read_base(file).backbone.state_dict() for file in (byte, base_file))
    for name, weights in whole.items():
        assert found[name].dtype == weights.dtype
        torch.testing.assert_close(found[name], weights, rtol=0, atol=float(weights.abs().max()) / 250 + 1e-7)
