"""Which repository holds the base of an adaptation: its model card says so."""

import re
from pathlib import Path

import yaml

from sb3_adaptnet.hub.address import SCHEME, parse_address

MODEL_CARD = "README.md"
"""The Hub's name for a model card."""
_METADATA = re.compile(r"\A---\s*\n(.*?)\n---", re.DOTALL)


def base_model_beside(file: Path) -> str | None:
    """Address of the base that the model card beside a weight file names; None if there is none or it names none."""
    card = file.with_name(MODEL_CARD)
    if not card.is_file():
        return None
    metadata = _METADATA.match(card.read_text(encoding="utf-8", errors="replace"))
    try:
        entries = yaml.safe_load(metadata[1] if metadata else "{}")
        return str(parse_address(f"{SCHEME}{entries['base_model']}"))
    except (yaml.YAMLError, KeyError, TypeError, ValueError):  # some other README
        return None
