"""What goes up to the Hub, and the sentences where it does not."""

from types import SimpleNamespace

import pytest
from hub_cases import huggingface_hub, offline_cache

from sb3_adaptnet.hub import HubError, parse_address
from sb3_adaptnet.publishing import upload

CARD = "---\nlibrary_name: adaptnet-gym\n---\n# x\n"


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "more").mkdir()
    for name in ("one.safetensors", "one.json", "picture.png", "replay.mp4", "code.py", "old.pt", "more/secret.json"):
        (tmp_path / "one" / name).write_text("x")
    (tmp_path / "one" / "README.md").write_text(CARD)
    return tmp_path / "one"


def test_nothing_that_could_run_goes_up(folder, monkeypatch):
    """The library's own upload needs the Hub; what it is asked for does not."""
    asked = []

    class Api:
        def create_repo(self, repo, **options):
            asked.append((repo, options))

        def upload_folder(self, **options):
            asked.append(options)
            return SimpleNamespace(commit_url="https://huggingface.co/me/one/commit/1")

    monkeypatch.setattr(huggingface_hub, "HfApi", Api)
    assert upload(folder, parse_address("hf://me/one"), private=True).endswith("/commit/1")
    (repo, made), sent = asked
    assert repo == sent["repo_id"] == "me/one" and made == {"private": True, "exist_ok": True}
    names = [str(file.relative_to(folder)) for file in folder.rglob("*")]
    chosen = {"allow_patterns": sent["allow_patterns"], "ignore_patterns": sent["ignore_patterns"]}
    sent_names = set(huggingface_hub.utils.filter_repo_objects(names, **chosen))
    assert sent_names == {"one.safetensors", "one.json", "picture.png", "replay.mp4", "README.md"}


def test_without_a_network_it_is_one_sentence(folder, tmp_path, monkeypatch):
    offline_cache(monkeypatch, tmp_path / "hub")
    with pytest.raises(HubError, match="^hf://me/one: it failed: .*offline") as caught:
        upload(folder, parse_address("hf://me/one"))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "text, complaint",
    [
        (None, "holds no README.md"),
        ("---\n- a\n---\n", "does not read"),
        ("# my project\n", r"is no publication \(library None in README.md\); make the folder with: adaptnet publish"),
    ],
)
def test_a_folder_without_a_model_card_is_refused(folder, text, complaint):
    (folder / "README.md").unlink() if text is None else (folder / "README.md").write_text(text)
    with pytest.raises(ValueError, match=complaint):
        upload(folder, parse_address("hf://me/one"))
