"""One weights file: tensors and a JSON card in a safetensors file, written atomically, read without running code."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save

from sb3_adaptnet.weights.atomic_file import write_atomically
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX
from sb3_adaptnet.weights.storage import in_bytes, restored, stored

FORMAT = 1
"""Version of the file's layout."""
_BYTE_FORMAT = 2
"""That of a file with 8 bits a number, which versions before 0.2.0 cannot read."""
_METADATA_KEY = "adaptnet"
"""Entry of the safetensors metadata that holds the card."""


class CheckpointError(ValueError):
    """A weights file is missing, damaged, foreign, or does not fit; the message says which, in one sentence."""


def weights_hash(tensors: Mapping[str, torch.Tensor], identity: Mapping[str, Any]) -> str:
    """SHA-256 over names, types, shapes and bytes of tensors and over JSON values that belong to them."""
    digest = hashlib.sha256(json.dumps(identity, sort_keys=True).encode())
    for name in sorted(tensors):
        tensor = tensors[name].detach().cpu().contiguous()
        digest.update(f"{name}{tensor.dtype}{tuple(tensor.shape)}".encode())
        digest.update(tensor.numpy().tobytes())
    return digest.hexdigest()


def write_weights(file: Path, tensors: Mapping[str, torch.Tensor], card: Mapping[str, Any], bits: int = 32) -> None:
    """Write tensors and card to `file`, and the card once more, for people, to the `.json` beside it.

    Both appear whole or not at all. The card is completed by the format version and the hash of the weights.

    Args:
        file: where to.
        tensors: by name.
        card: about them.
        bits: what a number of single precision is stored in: 32, 16 or 8. A network that is read from it computes in
            single precision all the same.

    Raises:
        ValueError: for other bits, and for a number beyond half precision's range.
    """
    _write(file, stored(tensors, bits), card)


def replace_card(file: Path, card: Mapping[str, Any]) -> None:
    """Write another card to a file of weights, which stay as they are stored; otherwise as `write_weights`.

    Raises:
        CheckpointError: if the file is missing, cut, damaged or not one of ours.
    """
    _write(file, _read(file, "cpu")[0], card)


def check_card_place(file: str | Path) -> None:
    """Refuse a file of weights whose card would replace something else.

    Raises:
        ValueError: naming what is there.
    """
    place = Path(f"{str(file).removesuffix(WEIGHT_SUFFIX)}.json")
    try:
        found = json.loads(place.read_bytes()) if place.exists() else {"format": None, "hash": None}
    except (ValueError, OSError):
        found = None
    if not (isinstance(found, dict) and {"format", "hash"} <= found.keys()):
        raise ValueError(f"{place} is there already and is no card of weights, which would replace it")


def _write(file: Path, tensors: Mapping[str, torch.Tensor], card: Mapping[str, Any]) -> None:
    check_card_place(file)
    layout = _BYTE_FORMAT if in_bytes(tensors) else FORMAT
    full = {**card, "format": layout, "hash": weights_hash(tensors, card.get("architecture", {}))}
    plain = {name: tensor.detach().cpu().contiguous().clone() for name, tensor in tensors.items()}
    file.parent.mkdir(parents=True, exist_ok=True)
    content = save(plain, metadata={_METADATA_KEY: json.dumps(full, sort_keys=True)})
    for_people = (json.dumps(full, indent=2, sort_keys=True) + "\n").encode()
    write_atomically(file, lambda stream: stream.write(content))
    write_atomically(file.with_suffix(".json"), lambda stream: stream.write(for_people))


def read_weights(file: Path, device: str | torch.device = "cpu") -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
    """Read what `write_weights` wrote.

    Returns:
        Tensors by name, those of 8 bits in single precision, and the card.

    Raises:
        CheckpointError: if the file is missing, cut, damaged or not one of ours.
    """
    tensors, card = _read(file, device)
    try:
        return restored(tensors), card
    except ValueError as error:
        raise CheckpointError(f"{str(file)!r} cannot be read: {error}") from error


def _read(file: Path, device: str | torch.device) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
    """Tensors as they are stored, and the card."""
    if not file.is_file():
        raise CheckpointError(f"there is no weights file {str(file)!r}")
    try:
        with safe_open(file, framework="pt", device=str(device)) as opened:
            metadata = opened.metadata() or {}
            tensors = {name: opened.get_tensor(name) for name in opened.keys()}  # noqa: SIM118 (not a mapping)
    except (SafetensorError, OSError, RuntimeError) as error:
        raise CheckpointError(f"{str(file)!r} is cut or is not a safetensors file ({error})") from error
    card = _read_card(file, metadata)
    if card["hash"] != weights_hash(tensors, card.get("architecture", {})):
        raise CheckpointError(f"{str(file)!r} is damaged: its weights do not have the hash that its card states")
    return tensors, card


def _read_card(file: Path, metadata: Mapping[str, str]) -> dict[str, Any]:
    if _METADATA_KEY not in metadata:
        raise CheckpointError(f"{str(file)!r} is a safetensors file, but holds no AdaptNet card")
    try:
        card = json.loads(metadata[_METADATA_KEY])
    except json.JSONDecodeError as error:
        raise CheckpointError(f"the card of {str(file)!r} is not JSON ({error})") from error
    if not isinstance(card, dict) or card.get("format") not in (FORMAT, _BYTE_FORMAT) or "hash" not in card:
        found = card.get("format") if isinstance(card, dict) else None
        known = f"{FORMAT} and {_BYTE_FORMAT}"
        raise CheckpointError(f"the card of {str(file)!r} has format {found!r}, but this version reads {known}")
    return card
