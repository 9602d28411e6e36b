"""A point in a drifting wind, dressed up as this project's humanoid: quick to simulate, learnable in seconds.

The state x (6 numbers) drifts outwards and is pushed by the first six actions; it "falls" where a component leaves
[-1, 1]. Staying near 0 is good: the goal reward is exp(-|x|^2) and the reference motion stays within 0.1 of 0. The
interface (observation, pose windows, infos, action space) is that of the real environments.
"""

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv

FRAMES, LINKS, JOINTS, STATE = 4, 15, 28, 6
TIME_LIMIT = 40


class ToySpace(gym.spaces.Box):
    """Box that carries what a policy needs to know of a character, as adapt_envs' JointSpace does."""

    def __init__(self, joints=JOINTS):
        super().__init__(-1.0, 1.0, (joints,), np.float32)
        self.joint_names = tuple(f"joint_{i}" for i in range(joints))
        self.default_base = "walk"
        self.mean_pose = np.zeros(joints, np.float32)

    def __setstate__(self, state):
        super().__setstate__(state)
        self.__dict__.update(state)


def windows_of(states: np.ndarray) -> np.ndarray:
    """States (N, 5, 6) to pose windows (N, 5, 15, 7): two links show the state, all stand upright."""
    windows = np.zeros((len(states), 5, LINKS, 7), np.float32)
    windows[..., 3] = 1.0
    windows[:, :, 1, :3], windows[:, :, 2, :3] = states[..., :3], states[..., 3:]
    return windows


def row_of(observations: Any, world: int) -> Any:
    """One world's observation, of an array or a dict of arrays."""
    return {k: v[world] for k, v in observations.items()} if isinstance(observations, dict) else observations[world]


class ToyVectorEnv(VectorEnv):
    """N toys with SAME_STEP autoreset and AdaptVectorEnv's names."""

    metadata = {"autoreset_mode": AutoresetMode.SAME_STEP, "render_modes": []}

    def __init__(self, num_envs=8, heightmap=False, drift=0.1, joints=JOINTS, num_threads=None, stagger=False):
        self.num_envs, self.heightmap, self.drift = num_envs, heightmap, drift
        flat = gym.spaces.Box(-np.inf, np.inf, (FRAMES * LINKS * 13 + 4,), np.float32)
        heights = gym.spaces.Box(-np.inf, np.inf, (1, 35, 35), np.float32)
        self.single_observation_space = gym.spaces.Dict(observation=flat, heightmap=heights) if heightmap else flat
        self.single_action_space = ToySpace(joints)
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, num_envs)
        self._history = np.zeros((num_envs, 5, STATE), np.float32)
        self._age = np.zeros(num_envs, np.int64)
        self.pose_windows = windows_of(self._history)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self._restart(np.ones(self.num_envs, bool))
        return self._observe(), {}

    def _restart(self, mask):
        self._history[mask] = self.np_random.uniform(-0.3, 0.3, (mask.sum(), 1, STATE))
        self._age[mask] = self.np_random.integers(0, 5, mask.sum())

    def _observe(self) -> Any:
        frames = np.zeros((self.num_envs, FRAMES, LINKS, 13), np.float32)
        frames[..., :7] = windows_of(self._history)[:, 1:]
        flat = np.concatenate([frames.reshape(self.num_envs, -1), np.ones((self.num_envs, 4), np.float32)], axis=1)
        if not self.heightmap:
            return flat
        return {"observation": flat, "heightmap": np.ones((self.num_envs, 1, 35, 35), np.float32)}

    def step(self, actions):
        x = self._history[:, -1] * (1.0 + self.drift) + 0.3 * np.asarray(actions)[:, :STATE]
        x = x + self.np_random.normal(0.0, 0.02, x.shape)
        self._history = np.concatenate([self._history[:, 1:], x[:, None].astype(np.float32)], axis=1)
        self._age += 1
        rewards = np.exp(-np.square(x).sum(axis=1))
        terminated = np.abs(x).max(axis=1) > 1.0
        truncated = ~terminated & (self._age >= TIME_LIMIT)
        self.pose_windows = windows_of(self._history)
        infos, done = {}, terminated | truncated
        if done.any():
            final, observations = np.full(self.num_envs, None, dtype=object), self._observe()
            for world in np.flatnonzero(done):
                final[world] = row_of(observations, world)
            infos["final_obs"] = final
            infos["final_info"] = {"end": np.where(terminated, "fall", np.where(truncated, "time", None))}
            self._restart(done)
        return self._observe(), rewards, terminated, truncated, infos

    def sample_reference_windows(self, n: int, rng: np.random.Generator) -> np.ndarray:
        return windows_of(rng.uniform(-0.1, 0.1, (n, 5, STATE)).astype(np.float32))


class ToyEnv(gym.Env):
    """One toy, for DummyVecEnv and SubprocVecEnv."""

    metadata = {"render_modes": []}

    def __init__(self, **kwargs):
        self.worlds = ToyVectorEnv(1, **kwargs)
        self.observation_space = self.worlds.single_observation_space
        self.action_space = self.worlds.single_action_space
        self.pose_windows = self.worlds.pose_windows[0]

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        observation, info = self.worlds.reset(seed=seed)
        return row_of(observation, 0), info

    def step(self, action):
        observation, reward, terminated, truncated, infos = self.worlds.step(action[None])
        self.pose_windows = self.worlds.pose_windows[0]
        if terminated[0] or truncated[0]:
            return (
                infos["final_obs"][0],
                float(reward[0]),
                bool(terminated[0]),
                bool(truncated[0]),
                {"end": infos["final_info"]["end"][0]},
            )
        return row_of(observation, 0), float(reward[0]), bool(terminated[0]), bool(truncated[0]), {}

    def sample_reference_windows(self, n, rng):
        return self.worlds.sample_reference_windows(n, rng)


gym.register("Toy-v0", entry_point=ToyEnv, vector_entry_point=ToyVectorEnv)
