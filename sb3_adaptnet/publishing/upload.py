"""From a folder to the Hub."""

from pathlib import Path

import yaml

from sb3_adaptnet.hub import HubAddress, HubError
from sb3_adaptnet.hub.base_model import MODEL_CARD
from sb3_adaptnet.hub.download import reason
from sb3_adaptnet.hub.extra import hub_library
from sb3_adaptnet.publishing.model_card import LIBRARY

ALLOWED = ("*.safetensors", "*.json", "*.npz", "*.png", "*.mp4", MODEL_CARD)
"""What goes up, none of it from folders within: nothing that could run."""


def check_publication(folder: Path) -> None:
    """Refuse a folder that is no publication, or whose model card the Hub's own library does not read.

    Raises:
        ValueError: saying why.
    """
    file = folder / MODEL_CARD
    if not file.is_file():
        raise ValueError(f"{folder}: holds no {MODEL_CARD}; make the folder with: adaptnet publish")
    try:
        library = hub_library().ModelCard.load(file).data.to_dict().get("library_name")
    except (ValueError, TypeError, KeyError, yaml.YAMLError) as error:
        raise ValueError(f"{file}: the Hub does not read its metadata ({' '.join(str(error).split())})") from error
    if library != LIBRARY or not list(folder.glob("*.safetensors")):
        found = f"library {library!r} in {MODEL_CARD}" if library != LIBRARY else "no weights"
        raise ValueError(f"{folder}: is no publication ({found}); make the folder with: adaptnet publish")


def upload(folder: Path, address: HubAddress, private: bool = False) -> str:
    """Put a folder into a repository, in one commit; the repository is made if there is none.

    Args:
        folder: what `write_folder` wrote.
        address: where to.
        private: whether a new repository is for its owner only.

    Returns:
        The commit's address in the browser.

    Raises:
        HubError: if the Hub refuses, or cannot be reached.
        ValueError: if the folder is not fit for it.
    """
    check_publication(folder)
    hub = hub_library()
    try:
        api = hub.HfApi()
        api.create_repo(address.repo, private=private, exist_ok=True)
        commit = api.upload_folder(
            repo_id=address.repo, folder_path=folder, revision=address.revision, allow_patterns=list(ALLOWED),
            ignore_patterns=["*/*"], commit_message=f"adaptnet push: {folder.name}",
        )  # fmt: skip
        return str(commit.commit_url)
    except Exception as error:  # see `download`
        raise HubError(f"{address}: {reason(hub, error)}") from error
