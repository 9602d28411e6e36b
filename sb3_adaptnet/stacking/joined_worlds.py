"""Worlds of several tasks as one batch, so that one policy learns in all of them at once."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvObs, VecEnvStepReturn

from sb3_adaptnet.modules.observation import COMPANION, parts_of
from sb3_adaptnet.stacking.parts import part_of
from sb3_adaptnet.vec_env import NO_INFO, AdaptVecEnv


class JoinedWorlds(VecEnv):
    """Groups of worlds of different tasks, stepped as one batch; every observation says which group it is of.

    Observations are dicts: what the groups' hold, and under "companion" the number (N,) of the group, int64.

    Attributes:
        groups: the worlds, in order.
        numbers: (N,) of each world's group.
    """

    def __init__(self, groups: Sequence[AdaptVecEnv]) -> None:
        """Join groups.

        Raises:
            ValueError: if there is none, or their spaces differ.
        """
        if not groups:
            raise ValueError("there are no worlds to join")
        self.groups = list(groups)
        first = self.groups[0]
        for group in self.groups[1:]:
            if group.observation_space != first.observation_space or group.action_space != first.action_space:
                found = f"{group.observation_space} and {group.action_space}"
                raise ValueError(f"worlds with {first.observation_space} and {first.action_space} cannot join {found}")
        parts = parts_of(first.observation_space)
        space = spaces.Dict({**parts, COMPANION: spaces.Discrete(len(self.groups))})
        super().__init__(sum(group.num_envs for group in self.groups), space, first.action_space)
        self.numbers = np.repeat(np.arange(len(self.groups)), [group.num_envs for group in self.groups])
        ends = np.cumsum([group.num_envs for group in self.groups])
        self._slices = [slice(end - group.num_envs, end) for group, end in zip(self.groups, ends, strict=True)]

    def _joined(self, observations: Sequence[Any]) -> dict[str, NDArray[Any]]:
        parts = [parts_of(observation) for observation in observations]
        return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]} | {
            COMPANION: self.numbers.copy()
        }

    def reset(self) -> VecEnvObs:
        """Reset all worlds, each group with a seed of its own if one was given; returns observations (N, ...)."""
        seed = self._seeds[0]
        for number, group in enumerate(self.groups):
            if seed is not None:
                group.seed(seed + 1000 * number)
        for group, rows in zip(self.groups, self._slices, strict=True):
            group.set_options(self._options[rows])
        self._reset_seeds()
        self._reset_options()
        return self._joined([group.reset() for group in self.groups])

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Hand each group its actions (N, joints)."""
        for group, rows in zip(self.groups, self._slices, strict=True):
            group.step_async(actions[rows])

    def step_wait(self) -> VecEnvStepReturn:
        """Step all worlds; finished ones are reset already."""
        observations, rewards, dones, infos = zip(*(group.step_wait() for group in self.groups), strict=True)
        found: list[dict[str, Any]] = []
        for number, group in enumerate(infos):
            found.extend(info if info is NO_INFO else self._numbered(info, number) for info in group)
        return self._joined(observations), np.concatenate(rewards), np.concatenate(dones), found

    @staticmethod
    def _numbered(info: dict[str, Any], number: int) -> dict[str, Any]:
        last = {**parts_of(info["terminal_observation"]), COMPANION: np.int64(number)}
        return {**info, "terminal_observation": last}

    @property
    def pose_windows(self) -> NDArray[np.float32]:
        """Windows (N, 5, 15 + k, 7) of the transition just made, before autoreset: position [m], quaternion wxyz.

        The last k links stand for none: their numbers are 1 at the group's and 0 elsewhere, so that discriminators
        tell the groups apart and compare each with its own clip.
        """
        return self._marked(np.concatenate([group.pose_windows for group in self.groups]), self.numbers)

    def sample_reference_windows(self, count: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """Sample windows (count, 5, 15 + k, 7) of the groups' clips, of each in proportion to its worlds."""
        numbers = np.sort(self.numbers[rng.integers(self.num_envs, size=count)])
        drawn = zip(self.groups, np.bincount(numbers, minlength=len(self.groups)), strict=True)
        windows = [group.sample_reference_windows(int(share), rng) for group, share in drawn if share]
        return self._marked(np.concatenate(windows), numbers)

    def _marked(self, windows: NDArray[np.float32], numbers: NDArray[np.integer]) -> NDArray[np.float32]:
        samples, frames, _, width = windows.shape
        marks = np.zeros((samples, -(-len(self.groups) // width) * width), np.float32)
        marks[np.arange(samples), numbers] = 1.0
        shape = (samples, frames, marks.shape[1] // width, width)
        return np.concatenate([windows, np.broadcast_to(marks.reshape(samples, 1, -1, width), shape)], axis=2)

    def close(self) -> None:
        """Free the worlds."""
        for group in self.groups:
            group.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Attribute of the worlds, once per index."""
        values = [value for group in self.groups for value in group.get_attr(attr_name)]
        return [values[i] for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute for all worlds; arrays with N rows give every world its row.

        Raises:
            AttributeError: if they have none of this name.
            ValueError: if only some worlds are named.
        """
        if indices is not None and len(list(self._get_indices(indices))) != self.num_envs:
            raise ValueError(f"{attr_name!r} can only be set for all {self.num_envs} worlds at once")
        per_world = isinstance(value, np.ndarray) and value.ndim > 0 and len(value) == self.num_envs
        for group, rows in zip(self.groups, self._slices, strict=True):
            group.set_attr(attr_name, value[rows] if per_world else value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of every group once, whatever `indices`; each result is repeated for its worlds."""
        results = [group.env_method(method_name, *method_args, **method_kwargs) for group in self.groups]
        values = [value for result in results for value in result]
        return [values[i] for i in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[gym.Wrapper], indices: VecEnvIndices = None) -> list[bool]:
        """As the groups say."""
        values = [value for group in self.groups for value in group.env_is_wrapped(wrapper_class)]
        return [values[i] for i in self._get_indices(indices)]


def worlds_with_companions(companions: Sequence[str | Path], num_envs: int = 512, **kwargs: Any) -> JoinedWorlds:
    """Worlds to learn in beside adaptations of the same base.

    Args:
        companions: names or files. The first group of worlds is without one, and twice as large as the others: what
            learns acts alone, too. Then comes one for each, with what it changes of its base's world: a style brings
            its motion and its speeds.
        num_envs: number of all worlds, at least one for each group; what is left over joins the first.
        **kwargs: arguments of `AdaptVecEnv`, such as env="AdaptNet/Humanoid-IceWalk-v0". Reference windows show the
            clips on these worlds' body unless `clip_on_body=False`: what a style's links should do with longer legs,
            the plain character's do not say.

    Raises:
        CheckpointError, ValueError: as `part_of`, or if the companions are no list of names and files.
    """
    if not isinstance(companions, list | tuple) or not all(isinstance(name, str | Path) for name in companions):
        raise ValueError(f"companions are {companions!r}, expected a list of adaptations' names or files")
    size = max(num_envs // (len(companions) + 2), 1)
    kwargs = {"clip_on_body": True, **kwargs}
    groups = [AdaptVecEnv(**kwargs, num_envs=max(num_envs - size * len(companions), 1))]
    groups += [AdaptVecEnv(**{**kwargs, **part_of(name).changes}, num_envs=size) for name in companions]
    return JoinedWorlds(groups)
