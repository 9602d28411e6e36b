"""The only adapter between this project's batched worlds and Stable-Baselines3's VecEnv."""

import time
from collections.abc import Sequence
from typing import Any, Protocol, cast

import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env.base_vec_env import VecEnv, VecEnvIndices, VecEnvObs, VecEnvStepReturn

import adapt_envs as adapt_envs  # registers the ids
from adapt_envs.features.observation_rows import Observations, copied
from adapt_envs.simulation.situations import Situations as Situations  # learners have it from here
from adapt_envs.simulation.state_access import ReferenceStates, StateAccess

NO_INFO: dict[str, Any] = {}
"""Info of every world that goes on, shared by them all; nobody writes into it."""


class PosedWorlds(Protocol):
    """What batched worlds offer to discriminators, beside gymnasium's `VectorEnv`."""

    @property
    def pose_windows(self) -> NDArray[np.float32]:
        """Windows (N, 5, 15, 7) of the transition just made, before autoreset: position [m], quaternion wxyz."""

    def sample_reference_windows(self, n: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """Windows (n, 5, 15, 7) of the clips."""


def _made_by(env: str | EnvSpec) -> tuple[str, dict[str, Any]]:
    """Id and arguments of an environment; of a spec its own time limit, where that is not the id's."""
    if isinstance(env, str):
        return env, {}
    own = env.max_episode_steps != gym.spec(env.id).max_episode_steps
    return env.id, {**({"max_episode_steps": env.max_episode_steps} if own else {}), **env.kwargs}


class AdaptVecEnv(VecEnv):
    """A gymnasium `VectorEnv` with SAME_STEP autoreset as a native Stable-Baselines3 `VecEnv`.

    No Python runs per world in a step: only worlds that finished get an info dict of their own, with "end",
    "terminal_observation", "TimeLimit.truncated" and "episode" (as `VecMonitor` writes it: r, l, t).
    Observations are copied, since PPO holds them across the next step.

    Attributes:
        vector_env: the gymnasium vector environment.
    """

    def __init__(
        self,
        env: str | EnvSpec | VectorEnv,
        num_envs: int = 512,
        num_threads: int | None = None,
        seed: int | None = None,
        stagger: bool = False,
        **env_kwargs: Any,
    ) -> None:
        """Make the worlds.

        Args:
            env: id, spec, or a finished vector environment (to which `num_envs` and what follows does not apply).
            num_envs: number of worlds N.
            num_threads: physics threads; None takes all cores.
            seed: seed of the first reset.
            stagger: for training: shorten the episodes that a reset begins, so that time limits come apart.
            **env_kwargs: further arguments of the environment.

        Raises:
            ValueError: if the environment has no such argument, or is not made for batches as this suite's are, whose
                worlds restart within the step that ends an episode (`AutoresetMode.SAME_STEP`).
            gymnasium.error.Error: if there is no such id, or it has no vector entry point.
        """
        if isinstance(env, VectorEnv):
            self.vector_env = env
        else:
            env_id, spec_kwargs = _made_by(env)
            kwargs = {"num_threads": num_threads, "stagger": stagger, **spec_kwargs, **env_kwargs}
            try:
                self.vector_env = gym.make_vec(env_id, num_envs, vectorization_mode="vector_entry_point", **kwargs)
            except TypeError as error:
                raise ValueError(f"{env_id} cannot be made with {', '.join(kwargs)}: {error}") from error
        self._started = time.time()
        made = self.vector_env
        mode = made.metadata.get("autoreset_mode")
        if mode != AutoresetMode.SAME_STEP:
            raise ValueError(f"{made} has the autoreset mode {mode}, where {AutoresetMode.SAME_STEP} is needed")
        super().__init__(made.num_envs, made.single_observation_space, made.single_action_space)
        self._seeds[0] = seed
        self._actions = np.zeros(self.vector_env.action_space.shape or (), np.float32)
        self._returns = np.zeros(self.num_envs)
        self._lengths = np.zeros(self.num_envs, np.int64)

    @property
    def pose_windows(self) -> NDArray[np.float32]:
        """Windows (N, 5, 15, 7) of the transition just made, before autoreset: position [m], quaternion wxyz."""
        return self._posed.pose_windows

    def sample_reference_windows(self, count: int, rng: np.random.Generator) -> NDArray[np.float32]:
        """Sample windows (count, 5, 15, 7) of the clips."""
        return self._posed.sample_reference_windows(count, rng)

    @property
    def _posed(self) -> PosedWorlds:
        return cast(PosedWorlds, self.vector_env.unwrapped)

    def reset(self) -> VecEnvObs:
        """Reset all worlds, with the seed given by `seed` if any; returns observations (N, ...)."""
        options = self._options[0] or None
        if any(one != self._options[0] for one in self._options):
            raise ValueError(f"all worlds are reset by the same options, not by {self._options}")
        observations, _ = self.vector_env.reset(seed=self._seeds[0], options=options)
        self._reset_seeds()
        self._reset_options()
        self._returns[:] = 0.0
        self._lengths[:] = 0
        return copied(observations)

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keep the actions (N, joints) for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Step all worlds; finished ones are reset already."""
        observations, rewards, terminated, truncated, infos = self.vector_env.step(self._actions)
        dones = np.logical_or(terminated, truncated)
        self._returns += rewards
        self._lengths += 1
        sb3_infos = [NO_INFO] * self.num_envs
        for world in np.flatnonzero(dones):
            sb3_infos[world] = self._final_info(int(world), infos, bool(truncated[world] and not terminated[world]))
        self._returns[dones] = 0.0
        self._lengths[dones] = 0
        return copied(observations), np.array(rewards, np.float32), dones, sb3_infos

    def _final_info(self, world: int, infos: dict[str, Any], truncated: bool) -> dict[str, Any]:
        observation, ends = infos["final_obs"][world], infos.get("final_info", {}).get("end")
        episode = {
            "r": round(float(self._returns[world]), 6),
            "l": int(self._lengths[world]),
            "t": round(time.time() - self._started, 6),
        }
        info = {"terminal_observation": observation, "TimeLimit.truncated": truncated, "episode": episode}
        return info if ends is None else {"end": str(ends[world]), **info}

    def restart(self, worlds: NDArray[np.integer], situations: Situations | None = None) -> Observations:
        """End the episodes of some worlds (n,) before their time and begin others.

        Args:
            worlds: their numbers.
            situations: n situations to go on from; None begins in sampled states of the reference motion.

        Returns:
            First observations of these n worlds.
        """
        self._returns[worlds] = 0.0
        self._lengths[worlds] = 0
        return copied(self.simulation.restart(worlds, situations))

    @property
    def simulation(self) -> StateAccess:
        """States, goals and reference motion of all worlds, for learners that model them.

        Raises:
            ValueError: if the worlds are not of this project.
        """
        worlds = self.vector_env.unwrapped
        if not isinstance(worlds, StateAccess):
            raise ValueError(f"{type(worlds).__name__} does not tell its worlds' states, as AdaptVectorEnv does")
        return worlds

    def references(self, gaits: Sequence[float] = ()) -> list[ReferenceStates]:
        """The reference motion; or gait cycles of it, one at about each of these speeds [m/s].

        Raises:
            MotionError: if it holds no cycle at any of the speeds, or is one itself.
        """
        return self.simulation.reference_gaits(gaits) if gaits else [self.simulation.reference_states]

    def close(self) -> None:
        """Free the worlds."""
        self.vector_env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Attribute of the vector environment, once per index; arrays with N rows give every world its row."""
        value = getattr(self.vector_env, attr_name)
        per_world = isinstance(value, np.ndarray) and value.ndim > 0 and len(value) == self.num_envs
        return [value[i] if per_world else value for i in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute that the worlds have, for all of them; single worlds have none of their own.

        Raises:
            AttributeError: if they have none of this name.
            ValueError: if only some worlds are named.
        """
        if not hasattr(self.vector_env.unwrapped, attr_name):
            raise AttributeError(f"{type(self.vector_env.unwrapped).__name__} has no attribute {attr_name!r} to set")
        if indices is not None and len(list(self._get_indices(indices))) != self.num_envs:
            raise ValueError(f"{attr_name!r} can only be set for all {self.num_envs} worlds at once")
        setattr(self.vector_env.unwrapped, attr_name, value)

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Call a method of the vector environment once; the result is repeated per index."""
        result = getattr(self.vector_env, method_name)(*method_args, **method_kwargs)
        return [result for _ in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: type[gym.Wrapper], indices: VecEnvIndices = None) -> list[bool]:
        """True for `Monitor`: episodes are reported as it does; no world has another wrapper."""
        return [issubclass(wrapper_class, Monitor) for _ in self._get_indices(indices)]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """Pictures of the worlds, as far as the vector environment renders them."""
        frames = self.vector_env.render()
        return [] if frames is None else [np.asarray(frame) for frame in frames]
