"""Numbers of a weights file, stored in 32, 16 or 8 bits."""

import pytest
import torch

from sb3_adaptnet.weights.card import amend_card
from sb3_adaptnet.weights.checkpoint import read_base, save_base
from sb3_adaptnet.weights.storage import restored, stored
from sb3_adaptnet.weights.weight_file import CheckpointError, read_weights, write_weights


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


def test_a_byte_is_off_by_little_of_the_largest_of_its_32(tensors):
    found = restored(stored(tensors, 8))
    assert found.keys() == tensors.keys()
    for name in ("matrix", "convolution"):
        assert found[name].dtype == torch.float32
        for numbers, off in zip(
            tensors[name].flatten().split(32), (found[name] - tensors[name]).flatten().split(32), strict=True
        ):
            assert off.abs().max() <= numbers.abs().max() / 253
        assert not torch.equal(found[name], tensors[name])
    assert torch.equal(found["bias"], tensors["bias"].half())
    assert torch.equal(found["count"], tensors["count"])


def test_zeros_stay_zero_and_tiny_numbers_do_not_vanish():
    assert torch.equal(restored(stored({"w": torch.zeros(3, 4)}, 8))["w"], torch.zeros(3, 4))
    assert restored(stored({"w": torch.full((2, 2), 1e-44)}, 8))["w"].abs().max() < 1e-40
    small = torch.full((5, 7), 1e-30)
    torch.testing.assert_close(restored(stored({"w": small}, 8))["w"], small, rtol=0.01, atol=0.0)


def test_what_cannot_be_stored_is_refused(tensors):
    with pytest.raises(ValueError, match="bits must be one of 32, 16, 8, not 4"):
        stored(tensors, 4)
    with pytest.raises(ValueError, match="w has numbers that are not finite, which 8 bits cannot hold"):
        stored({"w": torch.tensor([[1.0, torch.inf]])}, 8)


def test_another_card_leaves_the_bytes_as_they_are(base_model, tmp_path):
    file = save_base(base_model, tmp_path / "byte", bits=8)
    before, size = read_weights(file), file.stat().st_size
    amend_card(file, evaluation={"seed": 3})
    after = read_weights(file)
    assert file.stat().st_size < size + 100
    assert after[1] == before[1] | {"evaluation": {"seed": 3}}
    assert all(torch.equal(tensor, after[0][name]) for name, tensor in before[0].items())


def test_eight_bits_take_less_room_and_act_nearly_the_same(base_model, base_file, tmp_path):
    byte = save_base(base_model, tmp_path / "byte", bits=8)
    assert byte.stat().st_size < 0.45 * base_file.stat().st_size  # the card counts, too: the network is small
    found, whole = (read_base(file).backbone.state_dict() for file in (byte, base_file))
    for name, weights in whole.items():
        assert found[name].dtype == weights.dtype
        torch.testing.assert_close(found[name], weights, rtol=0, atol=float(weights.abs().max()) / 250 + 1e-7)


@pytest.mark.parametrize("factors", [{"w:scale": torch.ones(2)}, {"w": torch.ones(3, 3), "w:scale": torch.ones(2)}])
def test_factors_that_do_not_fit_are_refused(tmp_path, factors):
    write_weights(tmp_path / "odd.safetensors", factors, {})
    with pytest.raises(CheckpointError, match="odd.*the factors of w are not those of its bytes"):
        read_weights(tmp_path / "odd.safetensors")
