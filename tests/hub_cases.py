"""A Hub's local cache made by hand, and no network; not a test itself."""

import importlib
import shutil

import pytest

from sb3_adaptnet.hub import download

huggingface_hub = pytest.importorskip(
    "huggingface_hub", reason="the Hub needs an optional package: pip install 'adaptnet-gym[hub]'"
)
constants = importlib.import_module("huggingface_hub.constants")
COMMIT = "0123456789abcdef0123456789abcdef01234567"


def offline_cache(monkeypatch, folder):
    """An empty cache at `folder`, as `HF_HUB_OFFLINE=1` and `HF_HUB_CACHE` make it."""
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(folder))
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)
    download.cache_clear()
    return folder


def cached(cache, repo, *files, revision="main", commit=COMMIT):
    """Put files into the cache as if they had been downloaded from `repo`; return their folder."""
    storage = cache / f"models--{repo.replace('/', '--')}"
    snapshot = storage / "snapshots" / commit
    snapshot.mkdir(parents=True, exist_ok=True)
    (storage / "refs").mkdir(exist_ok=True)
    (storage / "refs" / revision).write_text(commit)
    for file in files:
        shutil.copy(file, snapshot / file.name)
    return snapshot
