"""How the numbers of a weights file are stored: whole, in half precision, or a byte each with a scale for each row."""

from collections.abc import Mapping

import torch

BITS = (32, 16, 8)
"""Bits of a stored number, for single precision; other types are stored as they are."""
_SCALE = ":scale"
"""Ends the name of a tensor's scales; no name of a module's state holds a colon."""
_LARGEST = 127


def stored(tensors: Mapping[str, torch.Tensor], bits: int) -> dict[str, torch.Tensor]:
    """Tensors as a file holds them.

    With 8 bits a matrix becomes whole numbers from -127 to 127 and a factor for each of its rows, the first axis:
    a number is off by at most 1/254 of its row's largest. Vectors are stored in half precision then.

    Args:
        tensors: by name.
        bits: one of `BITS`.

    Raises:
        ValueError: for other bits, and for a number beyond half precision's range.
    """
    if bits not in BITS:
        raise ValueError(f"bits must be one of {', '.join(map(str, BITS))}, not {bits!r}")
    result: dict[str, torch.Tensor] = {}
    for name, tensor in tensors.items():
        if bits == 32 or tensor.dtype != torch.float32:
            result[name] = tensor
        elif bits == 8 and tensor.ndim > 1:
            result[name], result[name + _SCALE] = _bytes(name, tensor)
        else:
            result[name] = _halved(name, tensor)
    return result


def restored(tensors: Mapping[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """What `stored` was given, to within its precision: bytes become single precision, halves stay halves."""
    result = {name: tensor for name, tensor in tensors.items() if not name.endswith(_SCALE)}
    for name, scale in tensors.items():
        if name.endswith(_SCALE):
            whole = tensors[name.removesuffix(_SCALE)]
            result[name.removesuffix(_SCALE)] = whole.float() * _over_rows(scale, whole)
    return result


def _bytes(name: str, tensor: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    if not tensor.isfinite().all():
        raise ValueError(f"{name} has numbers that are not finite, which 8 bits cannot hold")
    largest = tensor.flatten(1).abs().amax(1)
    scale = torch.where(largest > 0.0, largest / _LARGEST, torch.ones_like(largest))
    return (tensor / _over_rows(scale, tensor)).round().to(torch.int8), scale


def _over_rows(scale: torch.Tensor, tensor: torch.Tensor) -> torch.Tensor:
    return scale.view(-1, *[1] * (tensor.ndim - 1))


def _halved(name: str, tensor: torch.Tensor) -> torch.Tensor:
    short = tensor.half()
    if not torch.equal(short.isfinite(), tensor.isfinite()):
        raise ValueError(f"{name} has numbers beyond half precision, as {float(tensor.abs().max()):g}")
    return short
