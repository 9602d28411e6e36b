"""World models as files: weights, and a card with the character, the fit and its errors. Opening one runs no code."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from sb3_adaptnet.weights.checkpoint import build_checked, load_checked, resolve
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX, WORLD_SUFFIX
from sb3_adaptnet.weights.weight_file import CheckpointError, read_weights, write_weights
from sb3_adaptnet.world_model.character import Character
from sb3_adaptnet.world_model.model import Sizes, WorldModel

KIND = "world"
"""Kind of the files, as their card says."""


class WorldFile(NamedTuple):
    """A world model as read from its file.

    Attributes:
        model: the model.
        card: everything the file says about itself.
    """

    model: WorldModel
    card: dict[str, Any]


def beside_base(name_or_file: str | Path) -> Path:
    """Where the world model of a base lies: beside it, under its name.

    Raises:
        CheckpointError: if there is no such base.
    """
    base = resolve(name_or_file)
    return base.with_name(base.name.removesuffix(WEIGHT_SUFFIX) + WORLD_SUFFIX)


def has_world(base: str | Path) -> bool:
    """Whether a base has a world model beside it.

    Raises:
        CheckpointError: if there is no such base.
    """
    return beside_base(base).is_file()


def save_world(model: WorldModel, file: str | Path, **about: Any) -> Path:
    """Save a world model, in 8 bits a weight: its errors over the horizon stay as they are.

    Args:
        model: the model.
        file: where to; the suffix `.world.safetensors` is added if missing. A `.json` card appears beside it.
        **about: further entries of the card as JSON values: environment, training, errors, ...

    Returns:
        The file.
    """
    path = Path(file) if str(file).endswith(WORLD_SUFFIX) else Path(f"{file}{WORLD_SUFFIX}")
    architecture = {"character": model.character.to_dict(), "sizes": model.sizes._asdict()}
    write_weights(path, model.state_dict(), {"kind": KIND, "architecture": architecture, **about}, bits=8)
    return path


def read_world(file: str | Path) -> WorldFile:
    """Read a world model.

    Raises:
        CheckpointError: if there is none, or the file is damaged, foreign or something else.
    """
    path = Path(file)
    tensors, card = read_weights(path)
    if card.get("kind") != KIND:
        raise CheckpointError(f"{str(path)!r} holds {card.get('kind')!r}, not {KIND!r}")
    model = build_checked(path, card, lambda: _from_card(card["architecture"]))
    load_checked(model, tensors, path)
    return WorldFile(model, card)


def _from_card(architecture: Mapping[str, Any]) -> WorldModel:
    return WorldModel(Character.from_dict(architecture["character"]), Sizes(**architecture["sizes"]))
