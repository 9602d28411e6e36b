"""Worlds that motions are tracked in: one group, or several beside companions, each with a motion of its own."""

from collections.abc import Sequence
from itertools import chain
from typing import Any, NamedTuple, cast

import torch
from gymnasium import spaces

from sb3_adaptnet.algorithms.tracking.tracked_motion import TrackedMotion
from sb3_adaptnet.policies.space_contract import has_heightmap
from sb3_adaptnet.stacking import JoinedWorlds
from sb3_adaptnet.vec_env import AdaptVecEnv
from sb3_adaptnet.world_model.character import Character

Env = AdaptVecEnv | JoinedWorlds


class TrackedMotions(NamedTuple):
    """What tracked worlds follow.

    Attributes:
        together: the motions of all groups, one after another; phases count through it.
        of_groups: of each group of worlds.
    """

    together: TrackedMotion
    of_groups: list[TrackedMotion]

    @classmethod
    def of(cls, env: Env, character: Character, device: torch.device, gaits: Sequence[float]) -> "TrackedMotions":
        """Prepare what worlds of one character follow; `gaits` as in `references_of`.

        Raises:
            ValueError: if the worlds are of another character, as those of `set_env` can be.
        """
        if character_of(env) != character:
            raise ValueError("the worlds have another body than those that the model was made for: make a new SVG")
        references = references_of(env, gaits)
        motions = [TrackedMotion.of(character, device, own) for own in references]
        if len(motions) == 1:
            return cls(motions[0], motions)
        return cls(TrackedMotion.of(character, device, list(chain.from_iterable(references))), motions)


def worlds_of(env: Any, observation_space: spaces.Space) -> Env:
    """The worlds themselves.

    Raises:
        ValueError: for what are no worlds to track motions in.
    """
    ours = isinstance(env, AdaptVecEnv | JoinedWorlds)
    if not ours or has_heightmap(observation_space):
        found = "a heightmap" if ours else f"a {type(env).__name__}"
        raise ValueError(f"SVG learns in an AdaptVecEnv on flat ground without a heightmap, and found {found}")
    return cast(Env, env)


def groups_of(env: Env) -> list[AdaptVecEnv]:
    """The groups of joined worlds; other worlds are one."""
    return env.groups if isinstance(env, JoinedWorlds) else [env]


def character_of(env: Env) -> Character:
    """The character of all worlds.

    Raises:
        ValueError: if the groups' differ: one world model and one kinematics are for all of them.
    """
    first, *others = [Character.of(group.simulation.model) for group in groups_of(env)]
    if any(other != first for other in others):
        raise ValueError("SVG learns beside companions that change no body, such as styles")
    return first


def references_of(env: Env, gaits: Sequence[float]) -> list[list[Any]]:
    """Reference motions of each group, as `TrackedMotion` takes them.

    Args:
        env: the worlds.
        gaits: speeds of the gait cycles of motions of minutes [m/s]; clips that companions bring are cycles already.

    Raises:
        MotionError: if a motion holds no cycle at any of the speeds, or the first group's is one itself.
    """
    first, *others = groups_of(env)
    return [list(first.references(gaits)), *(_references_beside(group, gaits) for group in others)]


def _references_beside(group: AdaptVecEnv, gaits: Sequence[float]) -> list[Any]:
    whole = group.references()
    return list(whole if whole[0].cyclic or not gaits else group.references(gaits))
