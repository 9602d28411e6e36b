"""Addresses of weights on the Hub: `hf://OWNER/NAME[@REVISION][/FILE]`, as the Hub's own tools write them."""

import re
from dataclasses import dataclass
from pathlib import Path

SCHEME = "hf://"
_WORD = r"[A-Za-z0-9](?:[A-Za-z0-9._-]*[A-Za-z0-9])?"
_ADDRESS = re.compile(
    rf"(?P<repo>{_WORD}/{_WORD})(?:@(?P<revision>{_WORD}(?:/{_WORD})*?))?(?:/(?P<file>[^/@]+\.safetensors))?"
)


@dataclass(frozen=True)
class HubAddress:
    """Where weights are on the Hub.

    Attributes:
        repo: `OWNER/NAME`.
        revision: branch, tag or commit; None for the default branch.
        file: file in the repository; None for its only weight file.
    """

    repo: str
    revision: str | None = None
    file: str | None = None

    @property
    def owner(self) -> str:
        """The account or organisation."""
        return self.repo.partition("/")[0]

    def __str__(self) -> str:
        """The address as it is written."""
        revision = "" if self.revision is None else f"@{self.revision}"
        return f"{SCHEME}{self.repo}{revision}{'' if self.file is None else f'/{self.file}'}"


def is_address(name_or_file: str | Path) -> bool:
    """Whether this is meant as an address on the Hub."""
    return isinstance(name_or_file, str) and name_or_file.startswith(SCHEME)


def parse_address(text: str) -> HubAddress:
    """Read an address.

    Args:
        text: with or without `hf://`.

    Raises:
        ValueError: if it is none.
    """
    found = _ADDRESS.fullmatch(text.removeprefix(SCHEME))
    if found is None or ".." in text or "--" in found["repo"]:
        raise ValueError(f"{text!r} is no address on the Hub; write hf://OWNER/NAME, hf://OWNER/NAME@REVISION or"
                         f" hf://OWNER/NAME/FILE.safetensors")  # fmt: skip
    return HubAddress(found["repo"], found["revision"], found["file"])
