"""A folder that is ready for the Hub; it appears whole or not at all."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from adapt_envs import AdaptVectorEnv
from adapt_envs.motion.library import ships
from sb3_adaptnet.evaluation.recording import Acting
from sb3_adaptnet.hub import parse_address
from sb3_adaptnet.hub.base_model import MODEL_CARD
from sb3_adaptnet.publishing.model_card import FILM, PICTURE, model_card
from sb3_adaptnet.publishing.pictures import write_film, write_picture
from sb3_adaptnet.weights.checkpoint import ADAPTATION, BASE
from sb3_adaptnet.weights.weight_file import read_weights


@dataclass(frozen=True)
class Publication:
    """What is to be published, and as what.

    Attributes:
        file: the weight file.
        repo: `OWNER/NAME`, where it will lie.
        base_model: `OWNER/NAME` of an adaptation's base; None takes `OWNER/` and the base's name.
        license_id: the weights' licence as the Hub abbreviates it; None leaves it open.
    """

    file: Path
    repo: str
    base_model: str | None = None
    license_id: str | None = None

    def base_repo(self, card: dict[str, Any]) -> str | None:
        """Where an adaptation's base is said to lie; None for a base."""
        if card["kind"] != ADAPTATION:
            return None
        return parse_address(self.base_model or f"{parse_address(self.repo).owner}/{card['base']['name']}").repo


def publishable_card(file: Path) -> dict[str, Any]:
    """The card of weights that can be published.

    Raises:
        ValueError: if there are none, they are damaged or no policy's, or their card names no environment.
    """
    card = read_weights(file)[1]
    if card.get("kind") not in (BASE, ADAPTATION):
        raise ValueError(f"{file}: holds a {card.get('kind')} model, no policy; publish a base or an adaptation")
    if not card.get("environment"):
        raise ValueError(f"{file}: its card names no environment; save it with environment=...")
    return card


def write_folder(
    publication: Publication, folder: Path, acting: tuple[Acting, AdaptVectorEnv] | None = None, seconds: float = 10.0
) -> Path:
    """Write weights, card, model card, the clip if it does not ship, and picture and film.

    Args:
        publication: what, and as what.
        folder: where to; an earlier publication of the same weights is replaced.
        acting: the policy and its worlds, for picture and film; None leaves both out.
        seconds: length of the film.

    Returns:
        The folder.

    Raises:
        ValueError: if the folder holds something else, the weights are damaged, their card names no environment,
            or their clip is missing.
        RenderingError: if this machine cannot draw.
    """
    card = publishable_card(publication.file)
    if folder.exists():
        check_replaceable(folder, publication.file)
    part = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    part.mkdir(parents=True)
    try:
        _fill(part, publication, card, acting, seconds)
        shutil.rmtree(folder, ignore_errors=True)
        part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return folder


def check_replaceable(folder: Path, weights: Path) -> None:
    """Refuse a folder that is more than an earlier publication of these weights: it would be lost.

    Raises:
        ValueError: if anything is in it that `write_folder` does not write, or the weights themselves.
    """
    if not folder.is_dir() or not (folder / weights.name).is_file():
        raise ValueError(f"{folder}: is in the way, and holds no {weights.name}; choose another folder")
    if weights.resolve().parent == folder.resolve():
        raise ValueError(f"{folder}: is where {weights.name} itself lies; choose another folder")
    ours = {weights.name, f"{weights.stem}.json", MODEL_CARD, PICTURE, FILM}
    motion = read_weights(folder / weights.name)[1].get("motion")
    if isinstance(motion, str) and not ships(motion):
        ours.add(Path(motion).name)  # the clip of what was published before
    others = [path.name for path in sorted(folder.iterdir()) if path.name not in ours]
    if others:
        raise ValueError(f"{folder}: also holds {', '.join(others)}, which would be lost; choose another folder")


def _fill(
    folder: Path, publication: Publication, card: dict[str, Any], acting: tuple[Acting, AdaptVectorEnv] | None,
    seconds: float,
) -> None:  # fmt: skip
    file, name = publication.file, publication.file.stem
    shutil.copyfile(file, folder / file.name)
    (folder / f"{name}.json").write_text(json.dumps(card, indent=2, sort_keys=True) + "\n", encoding="utf-8")
    motion = card.get("motion")
    if motion is not None and not ships(motion):
        clip = file.with_name(Path(motion).name)
        if not clip.is_file():
            raise ValueError(f"{file}: its clip {clip.name!r} does not lie beside it")
        shutil.copyfile(clip, folder / clip.name)
    if acting is not None:
        write_picture(*acting, folder / PICTURE)
        write_film(*acting, folder / FILM, seconds)
    base_repo = publication.base_repo(card)
    text = model_card(name, card, publication.repo, base_repo, publication.license_id, acting is not None)
    (folder / MODEL_CARD).write_text(text, encoding="utf-8")
