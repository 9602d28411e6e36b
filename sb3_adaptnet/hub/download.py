"""Repositories of weights, out of the Hub's local cache or into it."""

from functools import lru_cache
from pathlib import Path
from typing import Any

from sb3_adaptnet.hub.address import HubAddress
from sb3_adaptnet.hub.extra import hub_library

WANTED = ("*.safetensors", "*.json", "*.npz", "README.md")
"""Files that acting needs, and nothing that could run: weights, cards and clips."""
NOT_WANTED = "*/*"
"""What lies in folders is none of ours."""


class HubError(ValueError):
    """Something on the Hub cannot be had; the message says what and why, in one sentence."""


@lru_cache(maxsize=64)
def download(address: HubAddress) -> Path:
    """Folder that holds a repository's weights and cards, fetched if it is not in the cache yet.

    Where there is no network, or `HF_HUB_OFFLINE` is set, what is in the cache counts. `HF_HOME` says where that is.
    A repository is looked up once in a process, so that all of it sees one revision.

    Raises:
        HubError: if there is no such repository or revision, or it cannot be reached and is not in the cache.
    """
    hub = hub_library()
    try:
        wanted = {"allow_patterns": list(WANTED), "ignore_patterns": [NOT_WANTED]}
        return Path(hub.snapshot_download(address.repo, revision=address.revision, **wanted))
    except Exception as error:  # the library's and its HTTP client's kinds have changed from release to release
        raise HubError(f"{address}: {reason(hub, error)}") from error


def reason(hub: Any, error: Exception) -> str:
    """Why the Hub failed, in words that say what to do."""
    errors = hub.errors
    if isinstance(error, errors.GatedRepoError):
        return "its owner asks for an agreement first; accept it on the Hub, then log in with: hf auth login"
    if isinstance(error, errors.RepositoryNotFoundError):
        return "there is no such repository, or it is private and this machine is not logged in (hf auth login)"
    if isinstance(error, errors.RevisionNotFoundError):
        return "the repository has no such revision"
    if isinstance(error, errors.LocalEntryNotFoundError):
        why = "HF_HUB_OFFLINE is set" if hub.constants.HF_HUB_OFFLINE else "the Hub cannot be reached"
        return f"it is not whole in the local cache, and {why}"
    return f"it failed: {' '.join(str(error).split()) or type(error).__name__}"
