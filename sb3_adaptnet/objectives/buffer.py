"""Rollout buffer of several objectives: K rewards, K values, one advantage (the paper's eq. 9)."""

from collections.abc import Generator, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.type_aliases import TensorDict

from sb3_adaptnet.modules.observation import parts_of, whole_of


class ValueNorm(Protocol):
    """What the buffer needs of PopArt: statistics over columns of returns."""

    def update(self, returns: torch.Tensor) -> None:
        """Take in returns (M, K) in real units, keeping the critic's denormalised outputs."""

    def normalize(self, x: torch.Tensor) -> torch.Tensor:
        """Real units to the critic's, (..., K)."""


class ObjectiveSamples(NamedTuple):
    """A minibatch of B samples, under the names that `PPO.train` reads.

    `old_values` and `returns` are flattened (B * K,), normalised, sample-major; `advantages` is combined (B,).
    """

    observations: torch.Tensor | TensorDict
    actions: torch.Tensor
    old_values: torch.Tensor
    old_log_prob: torch.Tensor
    advantages: torch.Tensor
    returns: torch.Tensor


Batches = Generator[ObjectiveSamples, None, None]


def generalized_advantages(
    rewards: NDArray[np.floating],
    values: NDArray[np.floating],
    last_values: NDArray[np.floating],
    dones: NDArray[np.bool_],
    gamma: float,
    gae_lambda: float,
) -> NDArray[np.floating]:
    """Compute generalised advantage estimates (Schulman et al. 2016), each objective by itself.

    Args:
        rewards: (T, N, K); a time limit's bootstrap is part of the reward already.
        values: (T, N, K) of the states before each step, in the rewards' units.
        last_values: (N, K) of the states after the last step.
        dones: (T, N) true where the step ended an episode, for whatever reason.
        gamma: discount factor.
        gae_lambda: decay of the estimator, in [0, 1].

    Returns:
        Advantages (T, N, K).
    """
    alive = 1.0 - dones.astype(np.float32)[..., None]
    next_values = np.concatenate([values[1:], last_values[None]])
    deltas = rewards + gamma * next_values * alive - values
    advantages = np.empty_like(deltas)
    running = np.zeros_like(last_values)
    for step in reversed(range(len(deltas))):
        running = deltas[step] + gamma * gae_lambda * alive[step] * running
        advantages[step] = running
    return advantages


def combine_advantages(
    advantages: NDArray[np.floating], weights: Sequence[float] | NDArray[np.floating]
) -> NDArray[np.float32]:
    """Standardise each objective over the whole rollout, then sum with weights (eq. 9: sum_k w_k A_k).

    Args:
        advantages: (T, N, K).
        weights: K weights, or (T, N, K).

    Returns:
        Combined advantages (T, N).
    """
    mean = advantages.mean(axis=(0, 1), dtype=np.float64)
    std = advantages.std(axis=(0, 1), dtype=np.float64)
    return ((advantages - mean) / (std + 1e-8) * np.asarray(weights, np.float64)).sum(axis=-1).astype(np.float32)


class ObjectiveRolloutBuffer(RolloutBuffer):
    """On-policy buffer of K objectives for Box and Dict observations.

    `PPO.collect_rollouts` asks for returns before the imitation rewards exist. So
    `compute_returns_and_advantage` only notes which episodes ended, and the callback calls `finish` once every
    reward column is known; `get` refuses to hand out samples before that.

    Attributes:
        observations: (T, N, ...) per key; flat ones of a Box under "observation", and what the callback lets it
            `keep`.
        values, returns: (T, N, K) in real units after `finish`.
        advantages: (T, N), standardised per objective and combined.
    """

    observations: dict[str, NDArray[Any]]  # type: ignore[assignment]  # SB3 has another class where they are dicts

    def __init__(
        self,
        *args: Any,
        num_objectives: int = 1,
        **kwargs: Any,
    ) -> None:
        """Build the buffer.

        Args:
            *args: `RolloutBuffer`'s, as are `kwargs`.
            num_objectives: K.
            **kwargs: see `args`.
        """
        self.num_objectives = num_objectives
        super().__init__(*args, **kwargs)

    def reset(self) -> None:
        """Start a rollout. The arrays are kept and overwritten."""
        if not hasattr(self, "log_probs"):
            self._allocate()
        self.pos, self.full, self.finished = 0, False, False

    def _allocate(self) -> None:
        shape = (self.buffer_size, self.n_envs)
        subspaces = parts_of(self.observation_space)
        self.observations = {k: np.zeros((*shape, *(s.shape or ())), s.dtype) for k, s in subspaces.items()}
        self.actions = np.zeros((*shape, self.action_dim), np.float32)
        self.episode_starts = np.zeros(shape, np.float32)
        self.rewards = np.zeros(shape, np.float32)
        self.log_probs = np.zeros(shape, np.float32)
        self.advantages = np.zeros(shape, np.float32)
        self.values = np.zeros((*shape, self.num_objectives), np.float32)
        self.returns = np.zeros((*shape, self.num_objectives), np.float32)
        self.last_dones = np.zeros(self.n_envs, bool)

    def add(
        self,
        obs: NDArray[Any] | dict[str, NDArray[Any]],
        action: NDArray[np.floating],
        reward: NDArray[np.floating],
        episode_start: NDArray[Any],
        value: torch.Tensor,
        log_prob: torch.Tensor,
    ) -> None:
        """Keep one step of all N worlds; `value` is (N, K)."""
        for key, values in parts_of(obs).items():
            self.observations[key][self.pos] = values
        self.actions[self.pos] = action.reshape(self.n_envs, self.action_dim)
        self.rewards[self.pos] = reward
        self.episode_starts[self.pos] = episode_start
        self.values[self.pos] = value.reshape(self.n_envs, self.num_objectives).cpu().numpy()
        self.log_probs[self.pos] = log_prob.reshape(self.n_envs).cpu().numpy()
        self.pos += 1
        self.full = self.pos == self.buffer_size

    def keep(self, remembered: Mapping[str, torch.Tensor]) -> None:
        """Keep what frozen networks made (N, width), by key, of the observations that `add` will keep next.

        It comes back with the samples' observations, so that an update's epochs need not compute it again.
        """
        for key, values in remembered.items():
            if key not in self.observations:
                self.observations[key] = np.zeros((self.buffer_size, *values.shape), np.float32)
            self.observations[key][self.pos] = values.cpu().numpy()

    def compute_returns_and_advantage(self, last_values: torch.Tensor, dones: NDArray[np.bool_]) -> None:
        """Note which worlds ended with the last step; the returns wait for `finish`."""
        del last_values  # the weighted sum of all objectives: of no use here
        self.last_dones = np.array(dones, bool)

    def finish(
        self,
        rewards: NDArray[np.float32],
        last_values: NDArray[np.float32],
        weights: Sequence[float] | NDArray[np.floating],
        value_norm: ValueNorm,
    ) -> None:
        """Fill in advantages and returns, and the critic's normaliser.

        Args:
            rewards: (T, N, K) in real units, time limits bootstrapped.
            last_values: (N, K) in real units, of the states after the rollout.
            weights: K weights of eq. 9, or (T, N, K) where they differ.
            value_norm: the policy's PopArt; takes in the returns before they are normalised for the loss.
        """
        dones = np.concatenate([self.episode_starts[1:] > 0.5, self.last_dones[None]])
        advantages = generalized_advantages(rewards, self.values, last_values, dones, self.gamma, self.gae_lambda)
        self.returns = (advantages + self.values).astype(np.float32)
        self.advantages = combine_advantages(advantages, weights)
        value_norm.update(self._columns(self.returns))
        self._flat = self._flatten(value_norm)
        self.finished = True

    def _columns(self, array: NDArray[np.floating]) -> torch.Tensor:
        return torch.from_numpy(array.reshape(-1, self.num_objectives)).to(self.device)

    def _flatten(self, value_norm: ValueNorm) -> dict[str, torch.Tensor]:
        """Per-sample tensors (T * N, ...) without the observations; views where nothing is computed."""
        size = self.buffer_size * self.n_envs
        return {
            "actions": torch.from_numpy(self.actions.reshape(size, -1)),
            "old_values": value_norm.normalize(self._columns(self.values)).cpu(),
            "old_log_prob": torch.from_numpy(self.log_probs.reshape(size)),
            "advantages": torch.from_numpy(self.advantages.reshape(size)),
            "returns": value_norm.normalize(self._columns(self.returns)).cpu(),
        }

    def get(self, batch_size: int | None = None) -> Batches:  # type: ignore[override]  # SB3's samples know no dicts
        """Yield minibatches in a random order.

        Raises:
            RuntimeError: if `finish` was not called on this rollout.
        """
        if not self.finished:
            raise RuntimeError(
                "the rollout has no imitation rewards yet: pass DiscriminatorRewardCallback to learn(), "
                "as when this model's objectives were set"
            )
        size = self.buffer_size * self.n_envs
        order = torch.from_numpy(np.random.permutation(size))
        for start in range(0, size, batch_size or size):
            yield self._samples(order[start : start + (batch_size or size)])

    def _samples(self, rows: torch.Tensor) -> ObjectiveSamples:
        size = self.buffer_size * self.n_envs
        flat = {k: v[rows].to(self.device) for k, v in self._flat.items()}
        observations = {
            k: torch.from_numpy(v.reshape(size, *v.shape[2:]))[rows].to(self.device)
            for k, v in self.observations.items()
        }
        return ObjectiveSamples(
            observations=whole_of(observations),
            actions=flat["actions"],
            old_values=flat["old_values"].flatten(),
            old_log_prob=flat["old_log_prob"],
            advantages=flat["advantages"],
            returns=flat["returns"].flatten(),
        )
