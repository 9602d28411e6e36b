"""From a file, or the name of a shipped one, to a policy that acts."""

from pathlib import Path
from typing import Any

import torch
from gymnasium import spaces

from sb3_adaptnet.hub import base_model_beside
from sb3_adaptnet.policies.adaptnet import AdaptNetPolicy
from sb3_adaptnet.policies.baselines import ProgressivePolicy
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.policies.pretrain import PretrainPolicy
from sb3_adaptnet.weights.checkpoint import (
    BASE,
    AdaptationFile,
    check_base,
    read_adaptation,
    read_base,
    read_kind,
    resolve,
)
from sb3_adaptnet.weights.shipped import WEIGHT_SUFFIX, pretrained_names
from sb3_adaptnet.weights.weight_file import CheckpointError, read_weights

_ADAPTING = {"adaptnet": AdaptNetPolicy, "progressive": ProgressivePolicy}
"""What a card calls its "method" -> the policy that acts with it."""


def load_policy(
    name_or_file: str | Path,
    env: Any,
    device: str | torch.device = "cpu",
    base: str | Path | None = None,
) -> ObjectivePolicy:
    """Open a base or an adaptation for acting; never runs code from the file.

    Args:
        name_or_file: name of a shipped base or adaptation, a path, or an address on the Hub, `hf://OWNER/NAME`.
        env: an environment, vectorised or not, for its observation and action spaces.
        device: "cpu", "cuda", ...
        base: the adaptation's base; None looks beside the adaptation, then among the shipped ones, then where its
            model card says.

    Returns:
        A policy in evaluation mode: `policy.predict(obs, deterministic=True)`. Its critic is fresh.

    Raises:
        CheckpointError: if a file is missing, damaged or foreign, or adapts another base.
        ValueError: if the environment does not fit the network.
    """
    file = resolve(name_or_file)
    observations, actions = _spaces(env)
    policy: ObjectivePolicy
    if read_kind(file) == BASE:
        policy = _base_policy(file, observations, actions)
    else:
        policy = _adapted_policy(read_adaptation(file), observations, actions, base)
    policy.to(device).train(False)
    return policy


def load_base_of(name_or_file: str | Path, env: Any, device: str | torch.device = "cpu") -> ObjectivePolicy | None:
    """Open the base that a policy began from, for acting; None if its card names none, or one that is not there.

    Args:
        name_or_file: name of a shipped base or adaptation, or a path: also a finetuned base began from another.
        env: see `load_policy`, as the next one.
        device: "cpu", "cuda", ...

    Raises:
        CheckpointError: if a file is missing, damaged or foreign.
        ValueError: if the environment does not fit the network.
    """
    file = resolve(name_or_file)
    base = _base_named(file, read_weights(file)[1])
    return None if base is None else load_policy(base, env, device)


def base_of_adaptation(name_or_file: str | Path) -> Path:
    """File of the base that an adaptation was made for: beside it, shipped, or on the Hub.

    Raises:
        CheckpointError: if there is none, a file is damaged, or the base has another hash than the one adapted.
    """
    read = read_adaptation(name_or_file)
    file = resolve(_find_base(read))
    base = read_base(file)
    check_base(read, base.name, base.hash)
    return file


def _spaces(env: Any) -> tuple[spaces.Space, spaces.Space]:
    """Spaces of one environment, also from a gymnasium VectorEnv."""
    observations = getattr(env, "single_observation_space", None) or env.observation_space
    return observations, getattr(env, "single_action_space", None) or env.action_space


def _base_policy(file: Path, observations: spaces.Space, actions: spaces.Space) -> PretrainPolicy:
    read = read_base(file)
    sizes = read.backbone.architecture
    policy = PretrainPolicy(observations, actions, _no_learning, sizes.gru_size, sizes.hidden_sizes)
    policy.assemble(read.backbone.with_joints(policy.joints))
    return policy


def _adapted_policy(
    read: AdaptationFile, observations: spaces.Space, actions: spaces.Space, base: str | Path | None
) -> ObjectivePolicy:
    method = read.card.get("method")
    if not isinstance(method, str) or method not in _ADAPTING:
        raise CheckpointError(f"{str(read.file)!r} was made by {method!r}, but known methods are {list(_ADAPTING)}")
    policy = _ADAPTING[method](observations, actions, _no_learning, base=base or _find_base(read))
    policy.load_adaptation(read.file)
    return policy


def _find_base(read: AdaptationFile) -> Path | str:
    found = _base_named(read.file, read.card)
    if found is None:
        raise CheckpointError(
            f"{str(read.file)!r} adapts base {_base_name(read.card)!r}, which is neither beside it nor among "
            f"{pretrained_names()}, and no model card beside it says where; say where it is with base=..."
        )
    return found


def _base_named(file: Path, card: dict[str, Any]) -> Path | str | None:
    """The base that a file's card names: beside the file, shipped, or where its model card says; None if nowhere.

    A shipped base of that name but with other weights gives way to the one on the Hub.
    """
    name = _base_name(card)
    beside = file.with_name(f"{name}{WEIGHT_SUFFIX}")
    if beside.is_file():
        return beside
    on_the_hub, shipped = base_model_beside(file), name in pretrained_names()
    if shipped and (on_the_hub is None or read_weights(resolve(name))[1]["hash"] == card["base"].get("hash")):
        return name
    return on_the_hub


def _base_name(card: dict[str, Any]) -> str:
    return str((card.get("base") or {}).get("name"))


def _no_learning(_: float) -> float:
    return 0.0
