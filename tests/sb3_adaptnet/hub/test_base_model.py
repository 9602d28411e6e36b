"""The base that a model card names."""

import pytest

from sb3_adaptnet.hub import base_model_beside


@pytest.mark.parametrize(
    "text, address",
    [
        ("---\nlicense: mit\nbase_model: someone/walk\n---\n# x\n", "hf://someone/walk"),
        ("---\nlicense: mit\n---\n", None),
        ("---\nbase_model: [a/b, c/d]\n---\n", None),
        ("---\nbase_model: ../../etc\n---\n", None),
        ("---\n: [\n---\n", None),
        ("# A README of something else\n", None),
        ("", None),
    ],
)
def test_only_a_model_card_names_one(tmp_path, text, address):
    (tmp_path / "README.md").write_text(text)
    assert base_model_beside(tmp_path / "stoop.safetensors") == address


def test_no_model_card(tmp_path):
    assert base_model_beside(tmp_path / "stoop.safetensors") is None
