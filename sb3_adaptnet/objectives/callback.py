"""Turns stock PPO into the paper's multi-objective imitation learner (sec. 6, eqs. 9-12)."""

import weakref
from collections.abc import Callable, Mapping
from typing import Any, cast

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.utils import obs_as_tensor

from sb3_adaptnet.modules.observation import COMPANION, FLAT
from sb3_adaptnet.objectives.buffer import ObjectiveRolloutBuffer
from sb3_adaptnet.objectives.imitation import ImitationObjective, check_imitation
from sb3_adaptnet.objectives.kl_step_size import KL_RANGE, KlRange, check_steps, kl_range_at, next_step_size
from sb3_adaptnet.objectives.pose_windows import pose_windows, reference_windows
from sb3_adaptnet.objectives.reward_terms import TERMS, RewardTerm
from sb3_adaptnet.objectives.rollout_log import Rollout
from sb3_adaptnet.objectives.schedule import Schedule, two
from sb3_adaptnet.objectives.weighting import DEFAULT_WEIGHTS, GOAL, IMITATION, ObjectiveWeights
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.policies.optimizer_groups import ACTOR, set_step_size, step_size


class DiscriminatorRewardCallback(BaseCallback):
    """Adds to `PPO.learn` discriminators, K rewards and values, and a step size that follows the KL divergence.

    While PPO collects, the callback copies goal rewards and pose windows. At a rollout's end it trains the
    discriminators for one pass, scores the windows (eq. 11), sets every objective's reward to `terminal_reward`
    where an episode ended by a fall, lost or diverged, adds the bootstrap of time limits per objective, and fills the
    buffer's advantages (eq. 9). It needs a policy of this package and an environment with `pose_windows` and
    `sample_reference_windows`, without `VecNormalize`. With another model it begins with fresh discriminators.

    Attributes:
        objectives: names in the order of the critic's columns.
        imitation: the discriminators; None before training starts and without the objective "imitation".
        metrics: means of the last rollout: goal_reward, imitation_reward, falls_per_minute, episode_length, ...
    """

    def __init__(
        self,
        objective_weights: Mapping[str, Schedule] | None = None,
        terminal_reward: float = -10.0,
        kl_range: KlRange | None = KL_RANGE,
        actor_lr_range: tuple[float, float] = (1e-6, 1e-3),
        discriminator: Mapping[str, Any] | None = None,
        reward_terms: Mapping[str, RewardTerm] | None = None,
        in_turns: Mapping[str, Schedule] | None = None,
        alone: Mapping[str, Schedule] | None = None,
        verbose: int = 0,
    ) -> None:
        """Choose objectives and their weights.

        Args:
            objective_weights: name to weight (w_k of eq. 9). "imitation" is the discriminators' reward, "goal" the
                environment's; every other name stands in `reward_terms` or in `TERMS` of `reward_terms.py`, as
                "footing" does. Default: 0.5 and 0.5. A weight is a number, or samples -> number, joined by straight
                lines: `{0: 0.5, 1_000_000: 0.2}`.
            terminal_reward: reward of every objective where an episode ended by a fall, lost or diverged.
            kl_range: range of the KL divergence that the actor's step size is adjusted for, each bound a number or
                samples -> number; None keeps the step size fixed.
            actor_lr_range: smallest and largest effective learning rate of the actor.
            discriminator: arguments of `ImitationObjective` (learning_rate, batch_size, gradient_penalty, ...).
            reward_terms: name to a function of PPO's local variables at a step (`new_obs`, `actions`,
                `infos`, `env`, ...) that returns rewards (N,).
            in_turns: name to the factor, 0 to 1, that an objective's weight has where the target is not ahead; the
                goal gets what is left, as in `{"tracking": 0.25}`.
            alone: likewise in worlds without a companion, where there are some with one.
            verbose: as in Stable-Baselines3.

        Raises:
            ValueError: for an objective without reward, a negative weight, a wrong range or an unknown argument.
        """
        super().__init__(verbose)
        self.weights = ObjectiveWeights(objective_weights or DEFAULT_WEIGHTS, in_turns, alone)
        self.reward_terms = {**TERMS, **(reward_terms or {})}
        self.terminal_reward = float(terminal_reward)
        self.kl_range = two("kl_range", kl_range) if kl_range is not None else None
        self.actor_lr_range = two("actor_lr_range", actor_lr_range)
        self.discriminator_kwargs = dict(discriminator or {})
        self.weights.check_rewards((IMITATION, GOAL, *self.reward_terms))
        check_steps(self.kl_range, self.actor_lr_range)
        check_imitation(self.discriminator_kwargs)
        self.objectives = self.weights.names
        self.imitation: ImitationObjective | None = None
        self.metrics: dict[str, float] = {}
        self.kl: float | None = None
        self.rng = np.random.default_rng()
        self._learner: Callable[[], BaseAlgorithm | None] = lambda: None  # whose discriminators these are
        self._in_training = False
        self._begun_at = 0  # samples before this rollout

    @property
    def _ppo(self) -> PPO:
        return cast(PPO, self.model)

    @property
    def _policy(self) -> ObjectivePolicy:
        return cast(ObjectivePolicy, self.model.policy)

    def _init_callback(self) -> None:
        model = self._ppo
        if not isinstance(model, PPO):
            raise ValueError(f"DiscriminatorRewardCallback goes with PPO, not with {type(model).__name__}")
        if not hasattr(model.policy, "set_objectives"):
            raise ValueError(
                f"DiscriminatorRewardCallback needs one of this package's policies (AdaptNetPolicy, PretrainPolicy), "
                f"not {type(model.policy).__name__}"
            )
        normalizing = model.get_vec_normalize_env()
        if normalizing is not None and (normalizing.norm_obs or normalizing.norm_reward):
            raise ValueError(
                "leave VecNormalize out: the policies normalise by themselves, and a base must see what it knows"
            )
        self._policy.set_objectives(self.weights.at(model.num_timesteps))
        if not self._in_training:
            self._stock_normalize_advantage, self._in_training = model.normalize_advantage, True
        model.normalize_advantage = False  # advantages are standardised per objective already
        self.buffer = model.rollout_buffer = self._make_buffer()
        self._weights()  # refuses factors that these worlds cannot have before anything is learned
        self.rollout = Rollout(model.n_steps, model.n_envs)
        if self.imitation is None or self._learner() is not model:
            self.rng = np.random.default_rng(model.seed)
            self._build_discriminators()
        self._learner = weakref.ref(model)

    def _make_buffer(self) -> ObjectiveRolloutBuffer:
        model = self._ppo
        return ObjectiveRolloutBuffer(
            model.n_steps,
            model.observation_space,
            model.action_space,
            device=model.device,
            gamma=model.gamma,
            gae_lambda=model.gae_lambda,
            n_envs=model.n_envs,
            num_objectives=len(self.objectives),
        )

    def _build_discriminators(self) -> None:
        if IMITATION not in self.objectives:
            return
        _, _, links, numbers = reference_windows(self.training_env, 1, np.random.default_rng(0)).shape
        settings = {"precision": self._policy.requested_precision, **self.discriminator_kwargs}
        settings["network"] = {"links": links, "numbers": numbers, **(settings.get("network") or {})}
        self.imitation = ImitationObjective(device=self.model.device, **settings)

    def _on_training_end(self) -> None:
        self._ppo.normalize_advantage = self._stock_normalize_advantage
        self._in_training = False

    def _on_rollout_start(self) -> None:
        self.rollout.clear()
        self._begun_at = self.model.num_timesteps
        self._policy.set_objectives(self.weights.at(self._begun_at))
        kl = self.logger.name_to_value.get("train/approx_kl")  # of the update between the two rollouts
        self.kl = float(kl) if kl is not None else None
        if self.kl_range is not None and self.kl is not None:
            self._set_step_size(self.kl, kl_range_at(self.kl_range, self.model.num_timesteps))

    def _set_step_size(self, kl: float, kl_range: tuple[float, float]) -> None:
        optimizer = self._policy.optimizer
        size = next_step_size(step_size(optimizer, ACTOR), kl, kl_range, self.actor_lr_range)
        set_step_size(optimizer, ACTOR, size)

    def _on_step(self) -> bool:
        step = self.locals
        rewards = {GOAL: step["rewards"]}
        rewards.update({name: term(step) for name, term in self.reward_terms.items() if name in self.objectives})
        windows = pose_windows(self.training_env) if self.imitation is not None else None
        self.rollout.add(rewards, step["dones"], step["infos"], windows)
        self.buffer.keep(self._policy.remembered)
        return True

    def _on_rollout_end(self) -> None:
        statistics = self._imitate()
        rewards = self.rollout.rewards
        columns = np.stack([rewards[name] for name in self.objectives], axis=-1)
        columns[self.rollout.terminated] = self.terminal_reward
        last_values = self._bootstrap(columns)
        self.buffer.finish(columns, last_values, self._weights(), self._policy.value_norm)
        self._record(statistics)

    def _weights(self) -> NDArray[np.float64]:
        """Weights of eq. 9 of the rollout's start: (K,), or (T, N, K) where they differ."""
        observed = self.buffer.observations
        goals = observed[FLAT][..., -self._policy.architecture.goal_size :]
        companions = observed[COMPANION].reshape(goals.shape[:-1]) if COMPANION in observed else None
        return self.weights.where(goals, companions, self._begun_at)

    def _imitate(self) -> dict[str, float]:
        """Train the discriminators on the rollout, then fill in the imitation reward."""
        if self.imitation is None or self.rollout.windows is None:
            return {}
        steps, worlds = self.rollout.shape
        windows = self.rollout.windows.reshape(steps * worlds, *self.rollout.windows.shape[2:])
        reference = reference_windows(self.training_env, len(windows), self.rng)
        statistics = self.imitation.update(windows, reference, self.rng)
        self.rollout.rewards[IMITATION] = self.imitation.rewards(windows).reshape(steps, worlds)
        return statistics

    def _bootstrap(self, columns: NDArray[np.float32]) -> NDArray[np.float32]:
        """Add gamma V(terminal observation) where a time limit ended an episode; return the last values (N, K)."""
        limits = self.rollout.time_limits
        observations = obs_as_tensor(self.rollout.observations_to_bootstrap(self.locals["new_obs"]), self.model.device)
        with torch.no_grad():
            values = self._policy.predict_objective_values(observations).cpu().numpy()
        for (step, world, _), value in zip(limits, values[: len(limits)], strict=True):
            columns[step, world] += self._ppo.gamma * value
        return values[len(limits) :]

    def _record(self, statistics: dict[str, float]) -> None:
        self.metrics = {f"{name}_reward": float(self.rollout.rewards[name].mean()) for name in self.objectives}
        self.metrics["falls_per_minute"] = self.rollout.falls_per_minute()
        if self.rollout.lengths:
            self.metrics["episode_length"] = float(np.mean(self.rollout.lengths))
        self.metrics["actor_lr"] = step_size(self._policy.optimizer, ACTOR)
        if self.kl is not None:
            self.metrics["kl"] = self.kl
        for name, value in self.metrics.items():
            self.logger.record(f"objectives/{name}", value)
        for name, value in statistics.items():
            self.metrics[f"discriminator_{name}"] = value
            self.logger.record(f"discriminator/{name}", value)
        self._record_explained_variance()

    def _record_explained_variance(self) -> None:
        buffer = self.buffer
        residual = (buffer.returns - buffer.values).var(axis=(0, 1)) / (buffer.returns.var(axis=(0, 1)) + 1e-8)
        for name, share in zip(self.objectives, residual, strict=True):
            self.logger.record(f"objectives/{name}_explained_variance", 1.0 - float(share))

    def state_dict(self) -> dict[str, Any]:
        """Discriminators and random state, for resuming a run (torch.save, weights_only)."""
        imitation = self.imitation.state_dict() if self.imitation is not None else None
        return {"imitation": imitation, "rng": self.rng.bit_generator.state}

    def load_state_dict(self, state: Mapping[str, Any]) -> None:
        """Restore what `state_dict` gave; call it after `init_callback`."""
        self.rng.bit_generator.state = state["rng"]
        if self.imitation is not None and state["imitation"] is not None:  # an objective may have come since
            self.imitation.load_state_dict(state["imitation"])
