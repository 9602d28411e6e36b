"""The Hub without its optional package."""

import sys

import pytest

from sb3_adaptnet import CheckpointError, load_policy
from sb3_adaptnet.hub import download


def test_the_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "huggingface_hub", None)
    download.cache_clear()
    with pytest.raises(CheckpointError, match=r"pip install 'adaptnet-gym\[hub\]'"):
        load_policy("hf://someone/walk", None)
