"""Addresses on the Hub: what is read, and what is refused."""

from pathlib import Path

import pytest

from sb3_adaptnet.hub import HubAddress, is_address, parse_address


@pytest.mark.parametrize(
    "text, repo, revision, file",
    [
        ("hf://someone/walk", "someone/walk", None, None),
        ("someone/walk", "someone/walk", None, None),
        ("hf://a/walk-stoop@v1.0", "a/walk-stoop", "v1.0", None),
        ("hf://a/b/walk.safetensors", "a/b", None, "walk.safetensors"),
        ("hf://a/b@refs/pr/1/walk.safetensors", "a/b", "refs/pr/1", "walk.safetensors"),
    ],
)
def test_addresses_are_read_and_written_back(text, repo, revision, file):
    found = parse_address(text)
    assert found == HubAddress(repo, revision, file)
    assert str(found).removeprefix("hf://") == text.removeprefix("hf://")
    assert found.owner == repo.split("/")[0]


@pytest.mark.parametrize(
    "text",
    ["hf://", "hf://walk", "hf://a/b/c", "hf://a/../b", "hf://a/b@", "hf://a/b/../x.safetensors", "hf://a/b/x.bin",
     "hf://a--b/c", "hf://-a/b", "hf:///a/b", "hf://a/b/c/x.safetensors", "hf://a/b@x/..", ""],
)  # fmt: skip
def test_anything_else_is_refused_by_name(text):
    with pytest.raises(ValueError, match="is no address on the Hub; write hf://OWNER/NAME") as caught:
        parse_address(text)
    assert repr(text) in str(caught.value)


def test_names_and_paths_are_no_addresses():
    assert is_address("hf://a/b")
    assert not any(map(is_address, ("walk", "a/b", "./hf", Path("hf://a/b"))))
