"""How the numbers of a weights file are stored: whole, in half precision, or a byte each with a factor for each few."""

from collections.abc import Mapping

import torch
from torch.nn.functional import pad

BITS = (32, 16, 8)
"""Bits of a stored number, for single precision; other types are stored as they are."""
_SCALE = ":scale"
"""Ends the name of a tensor's scales; no name of a module's state holds a colon."""
_LARGEST = 127
_BLOCK = 32
"""Numbers with one factor. The largest of a whole row of 1,000 is twice as large, and so is the error then."""


def stored(tensors: Mapping[str, torch.Tensor], bits: int) -> dict[str, torch.Tensor]:
    """Tensors as a file holds them.

    With 8 bits a matrix becomes whole numbers from -127 to 127 and a factor for each 32 of them, row after row:
    a number is off by at most a 254th of the largest of its 32. Vectors are stored in half precision then.

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
    """What `stored` was given, to within its precision: bytes become single precision, halves stay halves.

    Raises:
        ValueError: for factors without their bytes, or of another number of them.
    """
    result = {name: tensor for name, tensor in tensors.items() if not name.endswith(_SCALE)}
    for name, scale in tensors.items():
        if name.endswith(_SCALE):
            name = name.removesuffix(_SCALE)
            whole = tensors.get(name)
            if whole is None or scale.shape != (-(-whole.numel() // _BLOCK),):
                raise ValueError(f"the factors of {name} are not those of its bytes")
            result[name] = _single(whole, scale)
    return result


def in_bytes(tensors: Mapping[str, torch.Tensor]) -> bool:
    """Whether any of the tensors, as `stored` returns them, has 8 bits a number."""
    return any(name.endswith(_SCALE) for name in tensors)


def _bytes(name: str, tensor: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    if not tensor.isfinite().all():
        raise ValueError(f"{name} has numbers that are not finite, which 8 bits cannot hold")
    largest = _blocks(tensor).abs().amax(1)
    scale = largest / _LARGEST
    scale = torch.where(scale > 0.0, scale, 1.0)
    whole = (_blocks(tensor) / scale[:, None]).round()
    return whole.to(torch.int8).flatten()[: tensor.numel()].view(tensor.shape), scale


def _single(whole: torch.Tensor, scale: torch.Tensor) -> torch.Tensor:
    numbers = _blocks(whole.float()) * scale[:, None]
    return numbers.flatten()[: whole.numel()].view(whole.shape)


def _blocks(tensor: torch.Tensor) -> torch.Tensor:
    """The numbers of a tensor in rows of `_BLOCK`, with zeros at the end of the last one."""
    return pad(tensor.flatten(), (0, -tensor.numel() % _BLOCK)).view(-1, _BLOCK)


def _halved(name: str, tensor: torch.Tensor) -> torch.Tensor:
    short = tensor.half()
    if not torch.equal(short.isfinite(), tensor.isfinite()):
        raise ValueError(f"{name} has numbers beyond half precision, as {float(tensor.abs().max()):g}")
    return short
