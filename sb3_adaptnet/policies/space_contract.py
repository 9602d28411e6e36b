"""What a policy reads from the spaces: an SB3 policy sees nothing else of its environment."""

from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.heightmap import HEIGHTMAP_SIZE
from sb3_adaptnet.modules.observation import COMPANION, FLAT, HEIGHTMAP

_HEIGHTMAP_SHAPE = (1, HEIGHTMAP_SIZE, HEIGHTMAP_SIZE)


def _attribute(action_space: spaces.Space, name: str) -> Any:
    value = getattr(action_space, name, None)
    if value is None:
        raise ValueError(
            f"the action space must carry {name!r}, as the action spaces of this package's environments do "
            f"(joint_names, default_base, mean_pose), but {action_space} has none"
        )
    return value


def action_joints(action_space: spaces.Space) -> tuple[str, ...]:
    """Names of the actuated joints, in the order of the actions.

    Raises:
        ValueError: if the space does not carry them, or not as many as it has actions.
    """
    joints = tuple(_attribute(action_space, "joint_names"))
    if action_space.shape != (len(joints),):
        raise ValueError(f"the action space has shape {action_space.shape}, but names {len(joints)} joints")
    return joints


def mean_pose(action_space: spaces.Space) -> NDArray[np.float32]:
    """The clips' mean pose as an action (n,) in [-1, 1], at which a fresh policy starts.

    Raises:
        ValueError: if the space does not carry it.
    """
    return np.asarray(_attribute(action_space, "mean_pose"), dtype=np.float32)


def default_base(action_space: spaces.Space) -> str:
    """Name of the base that the environment is meant to adapt.

    Raises:
        ValueError: if the space does not carry it.
    """
    return str(_attribute(action_space, "default_base"))


def has_heightmap(observation_space: spaces.Space) -> bool:
    """Whether observations come with a heightmap.

    Raises:
        ValueError: if the space is neither a flat Box nor a Dict of "observation" and "heightmap".
    """
    if isinstance(observation_space, spaces.Box) and len(observation_space.shape) == 1:
        return False
    keys = set(observation_space.spaces) - {COMPANION} if isinstance(observation_space, spaces.Dict) else set()
    if keys == {FLAT}:
        return False
    if isinstance(observation_space, spaces.Dict) and keys == {FLAT, HEIGHTMAP}:
        shape = observation_space[HEIGHTMAP].shape
        if shape != _HEIGHTMAP_SHAPE:
            raise ValueError(f"heightmaps must have shape {_HEIGHTMAP_SHAPE}, not {shape}")
        return True
    raise ValueError(
        f"observations must be Box(784,) or Dict(observation=Box(784,), heightmap=Box{_HEIGHTMAP_SHAPE}), "
        f"not {observation_space}"
    )


def companions_in(observation_space: spaces.Space) -> int:
    """How many companions the observations tell apart; 0 if they name none."""
    number = observation_space.get(COMPANION) if isinstance(observation_space, spaces.Dict) else None
    return int(number.n) - 1 if isinstance(number, spaces.Discrete) else 0


def check_network_fits(architecture: Architecture, observation_space: spaces.Space) -> None:
    """Refuse a network that reads other observations than the environment gives.

    Raises:
        ValueError: for another width, or a heightmap that is missing.
    """
    flat = observation_space["observation"] if isinstance(observation_space, spaces.Dict) else observation_space
    shape = flat.shape
    if shape != (architecture.observation_size,):
        raise ValueError(f"observations have shape {shape}, but the network reads ({architecture.observation_size},)")
    if architecture.heightmap and not has_heightmap(observation_space):
        raise ValueError(f"the network reads a heightmap, but the observation space {observation_space} has none")
