"""Where the shipped files are: inside an installed wheel, or at the root of a checkout."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
WEIGHT_SUFFIX = ".safetensors"
WORLD_SUFFIX = ".world.safetensors"
"""How names of world models end; each lies beside the base that it was fitted with."""


def _folders(relative: str) -> tuple[Path, Path]:
    return _PACKAGE / relative, _PACKAGE.parent / relative


def pretrained_names() -> list[str]:
    """Names of the shipped bases and adaptations, sorted."""
    files = (file for folder in _folders("assets/pretrained") for file in folder.glob(f"*{WEIGHT_SUFFIX}"))
    return sorted({file.stem for file in files if not file.name.endswith(WORLD_SUFFIX)})


def pretrained_path(name: str) -> Path:
    """File of a shipped base or adaptation.

    Args:
        name: such as "walk".

    Raises:
        ValueError: if there is none of that name.
    """
    for folder in _folders("assets/pretrained"):
        file = folder / f"{name}{WEIGHT_SUFFIX}"
        if file.is_file():
            return file
    raise ValueError(f"no pretrained weights named {name!r}; there are {pretrained_names()}")


def zoo_config_path(name: str) -> Path:
    """File of a shipped experiment configuration.

    Args:
        name: file name in `zoo_configs`, with or without ".yml".

    Raises:
        ValueError: if there is none of that name.
    """
    return _yaml_path("zoo_configs", name, "experiment configuration")


def sweep_path(name: str) -> Path:
    """File of a shipped sweep.

    Args:
        name: file name in `zoo_configs/sweeps`, with or without ".yml".

    Raises:
        ValueError: if there is none of that name.
    """
    return _yaml_path("zoo_configs/sweeps", name, "sweep")


def _yaml_path(relative: str, name: str, kind: str) -> Path:
    folders = _folders(relative)
    for folder in folders:
        file = folder / f"{name.removesuffix('.yml')}.yml"
        if file.is_file():
            return file
    known = sorted({file.stem for folder in folders for file in folder.glob("*.yml")})
    raise ValueError(f"no {kind} named {name!r}; there are {known}")
