"""The weight file that an address on the Hub stands for."""

from pathlib import Path

from sb3_adaptnet.hub import HubAddress, download, parse_address
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX, WORLD_SUFFIX
from sb3_adaptnet.weights.weight_file import CheckpointError


def hub_file(address: str) -> Path:
    """The weight file at `hf://OWNER/NAME[@REVISION][/FILE]`, in the Hub's local cache.

    Raises:
        CheckpointError: if the address is none, or what it names cannot be had.
    """
    try:
        found = parse_address(address)
        return _chosen(download(found), found)
    except CheckpointError:
        raise
    except ValueError as error:
        raise CheckpointError(str(error)) from error


def _chosen(folder: Path, address: HubAddress) -> Path:
    """The file that is named, else the only one that holds a policy."""
    names = sorted(f.name for f in folder.glob(f"*{WEIGHT_SUFFIX}") if not f.name.endswith(WORLD_SUFFIX))
    if address.file is not None:
        if address.file not in names:
            raise CheckpointError(f"{address}: there is no such file; the repository's weight files are {names}")
        return folder / address.file
    if len(names) != 1:
        raise CheckpointError(f"{address}: one weight file is expected, or its name; found {names}")
    return folder / names[0]
