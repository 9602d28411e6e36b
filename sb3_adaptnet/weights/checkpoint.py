"""Bases and adaptations as files: what they hold, and what they refuse."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import torch
from torch import nn

from sb3_adaptnet.hub import is_address
from sb3_adaptnet.modules.architecture import OBSERVATION_VERSION, Architecture
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.weights.hub_file import hub_file
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX, pretrained_path
from sb3_adaptnet.weights.weight_file import CheckpointError, read_weights, write_weights

BASE = "base"
"""Kind of a file that holds a whole policy network."""
ADAPTATION = "adaptation"
"""Kind of a file that holds only what was added to a base."""


class Base(NamedTuple):
    """A base as read from its file.

    Attributes:
        backbone: the network.
        name: the file's stem.
        hash: hash of its weights, which adaptations refer to.
        card: everything the file says about itself.
    """

    backbone: Backbone
    name: str
    hash: str
    card: dict[str, Any]


class AdaptationFile(NamedTuple):
    """An adaptation as read from its file.

    Attributes:
        file: where it was.
        tensors: its weights, by name.
        card: everything the file says about itself.
    """

    file: Path
    tensors: dict[str, torch.Tensor]
    card: dict[str, Any]


class Exportable(Protocol):
    """What saving needs of a policy."""

    def set_training_mode(self, mode: bool) -> None:
        """Put collected input statistics to use, as the next rollout would."""

    def export(self) -> tuple[str, nn.Module, dict[str, Any]]:
        """(kind, module with the weights to save, card entries)."""


def resolve(name_or_file: str | Path) -> Path:
    """The file that a name of a shipped one, a path, or an address on the Hub stands for.

    Raises:
        CheckpointError: if it is none of them, or the Hub does not give it.
    """
    if is_address(name_or_file):
        return hub_file(str(name_or_file))
    path = Path(name_or_file)
    if path.suffix or len(path.parts) != 1 or path.is_file():
        return path
    try:
        return pretrained_path(str(name_or_file))
    except ValueError as error:
        raise CheckpointError(f"{error}; nor is there such a file") from error


def save_base(model_or_policy: Any, file: str | Path, bits: int = 32, **about: Any) -> Path:
    """Save the policy network of a pretrained or finetuned policy; the critic is not part of it.

    Args:
        model_or_policy: a PPO model, or its policy.
        file: where to; the suffix `.safetensors` is added if missing. A `.json` card appears beside it.
        bits: what a weight is stored in: 32, 16, in half the room, or 8, in a quarter.
        **about: further entries of the card as JSON values: environment, clip_hash, training, metrics, ...

    Returns:
        The file.

    Raises:
        ValueError: for a policy that is an adaptation, and for other bits.
    """
    return _save(model_or_policy, file, BASE, bits, about)


def save_adaptation(model_or_policy: Any, file: str | Path, bits: int = 32, **about: Any) -> Path:
    """Save what a policy adds to its base, and nothing of the base but its name and hash; otherwise as `save_base`.

    Raises:
        ValueError: for a policy that is not an adaptation, or whose adaptors were merged into the base.
    """
    return _save(model_or_policy, file, ADAPTATION, bits, about)


def _save(model_or_policy: Any, file: str | Path, kind: str, bits: int, about: Mapping[str, Any]) -> Path:
    policy: Exportable = getattr(model_or_policy, "policy", model_or_policy)
    if not hasattr(policy, "export"):
        raise ValueError(f"only policies of this package can be saved, not {type(policy).__name__}")
    policy.set_training_mode(False)
    own_kind, module, entries = policy.export()
    if own_kind != kind:
        raise ValueError(f"{type(policy).__name__} is saved as {own_kind!r} (save_{own_kind}), not as {kind!r}")
    reserved = sorted(set(about) & {*entries, "kind", "format", "hash", "observation_version"})
    if reserved:
        raise ValueError(f"the card's entries {reserved} are taken; choose other names")
    path = Path(file) if str(file).endswith(WEIGHT_SUFFIX) else Path(f"{file}{WEIGHT_SUFFIX}")
    card = {"kind": kind, "observation_version": OBSERVATION_VERSION, **entries, **about}
    write_weights(path, module.state_dict(), card, bits)
    return path


def read_base(name_or_file: str | Path) -> Base:
    """Read a base.

    Args:
        name_or_file: name of a shipped base, or a path.

    Raises:
        CheckpointError: if there is none, or the file is damaged, foreign or an adaptation.
    """
    file = resolve(name_or_file)
    tensors, card = _read(file, BASE)
    backbone = build_checked(file, card, lambda: Backbone(Architecture.from_dict(card["architecture"])))
    load_checked(backbone, tensors, file)
    return Base(backbone, file.stem, card["hash"], card)


def read_adaptation(name_or_file: str | Path) -> AdaptationFile:
    """Read an adaptation; which networks its weights belong in, its card says.

    Raises:
        CheckpointError: if there is none, or the file is damaged, foreign or a base.
    """
    file = resolve(name_or_file)
    return AdaptationFile(file, *_read(file, ADAPTATION))


def read_kind(name_or_file: str | Path) -> str:
    """What a file holds: "base" or "adaptation".

    Raises:
        CheckpointError: if there is none, or it is damaged or foreign.
    """
    return str(_read(resolve(name_or_file), None)[1]["kind"])


def check_base(adaptation: AdaptationFile, base_name: str, base_hash: str) -> None:
    """Refuse a base that an adaptation was not made for.

    Raises:
        CheckpointError: if the base's hash is not the one in the adaptation's card.
    """
    wanted = adaptation.card.get("base") or {}
    if wanted.get("hash") != base_hash:
        raise CheckpointError(
            f"{str(adaptation.file)!r} adapts base {wanted.get('name')!r} (hash {str(wanted.get('hash'))[:12]}), "
            f"not {base_name!r} (hash {base_hash[:12]})"
        )


def _read(file: Path, kind: str | None) -> tuple[dict[str, torch.Tensor], dict[str, Any]]:
    tensors, card = read_weights(file)
    if card.get("kind") not in (BASE, ADAPTATION):
        raise CheckpointError(f"{str(file)!r} holds {card.get('kind')!r}, but should hold a base or an adaptation")
    if kind is not None and card["kind"] != kind:
        raise CheckpointError(f"{str(file)!r} holds {card['kind']!r}, not {kind!r}")
    if card.get("observation_version") != OBSERVATION_VERSION:
        raise CheckpointError(
            f"{str(file)!r} reads observations of version {card.get('observation_version')!r}, "
            f"but this package's are of version {OBSERVATION_VERSION}"
        )
    if not isinstance(card.get("base") or {}, dict):
        raise CheckpointError(f"the card of {str(file)!r} names {card['base']!r} as its base, not a name and a hash")
    if not all(bool(torch.isfinite(tensor).all()) for tensor in tensors.values()):
        raise CheckpointError(f"{str(file)!r} holds weights that are not finite numbers")
    return tensors, card


def build_checked(file: Path, card: Mapping[str, Any], build: Any) -> Any:
    """What `build()` makes of a card, or a CheckpointError if the card does not describe a network."""
    try:
        return build()
    except (KeyError, TypeError, ValueError, AttributeError, RuntimeError) as error:  # also sizes beyond all memory
        raise CheckpointError(f"the card of {str(file)!r} does not describe a network ({error})") from error


def load_checked(module: nn.Module, tensors: Mapping[str, torch.Tensor], file: Path) -> None:
    """Load weights, or raise a CheckpointError that says in one sentence what does not fit."""
    own = {name: tuple(tensor.shape) for name, tensor in module.state_dict().items()}
    found = {name: tuple(tensor.shape) for name, tensor in tensors.items()}
    wrong = sorted(name for name in own.keys() | found.keys() if own.get(name) != found.get(name))
    if wrong:
        raise CheckpointError(
            f"weights in {str(file)!r} do not fit the network that its card describes: "
            f"{wrong[0]!r} has shape {found.get(wrong[0])} instead of {own.get(wrong[0])}"
        )
    module.load_state_dict(dict(tensors))
