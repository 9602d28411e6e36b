"""How every policy of this package acts and is trained: K values, precision, normalisers."""

from collections.abc import Iterator, Mapping
from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.distributions import DiagGaussianDistribution
from stable_baselines3.common.type_aliases import PyTorchObs, Schedule

from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer, moments_of
from sb3_adaptnet.modules.layers.precision import PRECISIONS, autocast, use_precision
from sb3_adaptnet.modules.observation import Observation, read_observation
from sb3_adaptnet.policies.assembled import AssembledPolicy
from sb3_adaptnet.policies.rollout_length import RolloutLength
from sb3_adaptnet.policies.scaled_adam import ScaledAdam


class ObjectivePolicy(AssembledPolicy):
    """An actor and a critic with K objectives, for stock `PPO`.

    Without the callback K is 1 and values are plain numbers. `set_objectives` gives the critic K outputs with running
    statistics (PopArt): `forward` then returns values (B, K) in real units, `evaluate_actions` normalised ones, and
    `predict_values` their weighted sum (B, 1).

    Attributes:
        remembered: what frozen networks made of the observations of the last `forward`: (B, width) by key, such as
            "base_code". The callback takes it from here to the buffer, and the buffer's samples hand it back, beside
            "observation", to `evaluate_actions`: an update's epochs need not compute again what cannot change.
            It is an attribute because `PPO.collect_rollouts` calls `forward` and passes on three tensors, no more;
            computing again where the callback can ask, after the step, would cost what this is to save.
        precision: the precision in use: "fp32", "medium" or "bf16".
    """

    def __init__(
        self,
        observation_space: spaces.Space,
        action_space: spaces.Space,
        lr_schedule: Schedule,
        use_sde: bool = False,
        precision: str = "fp32",
        actor_lr: float | None = None,
        critic_lr: float | None = None,
        critic: Mapping[str, Any] | None = None,
        optimizer_class: type[torch.optim.Optimizer] = ScaledAdam,
        optimizer_kwargs: dict[str, Any] | None = None,
    ) -> None:
        """Build the networks and the optimiser.

        Args:
            observation_space: Box(784,), or Dict(observation=Box(784,), heightmap=Box(1, 35, 35)).
            action_space: a Box that carries `joint_names`, `default_base` and `mean_pose`.
            lr_schedule: PPO's learning rate; its value at the start is what actor_lr and critic_lr are relative to.
            use_sde: not supported; PPO passes it.
            precision: "fp32"; "medium" (float32 products in bfloat16 steps, set for the whole process); "bf16"
                (autocast, heads stay float32); "auto" (bf16 where the device has it).
            actor_lr: the actor's learning rate at the start; None takes PPO's.
            critic_lr: the critic's; None takes PPO's.
            critic: fields of `CriticShape`: encoder and hidden_sizes; None for the paper's.
            optimizer_class: an optimiser that honours each group's "lr_scale".
            optimizer_kwargs: further arguments of the optimiser.

        Raises:
            ValueError: for spaces without what the policy needs, an unknown precision or critic, or use_sde.
        """
        if use_sde:
            raise ValueError("use_sde=True is not supported: the standard deviation is a head of the network")
        if precision not in (*PRECISIONS, "auto"):
            raise ValueError(f"precision must be one of {[*PRECISIONS, 'auto']}, not {precision!r}")
        super().__init__(
            observation_space, action_space, lr_schedule, actor_lr, critic_lr, critic, optimizer_class, optimizer_kwargs
        )
        self.requested_precision = precision
        self.precision = use_precision(precision)
        self.remembered: dict[str, torch.Tensor] = {}
        self._rollout_length = RolloutLength()

    def _split(self, obs: PyTorchObs) -> Observation:
        return read_observation(obs, self.architecture)

    def _remembering(self, observation: Observation) -> Observation:
        """For policies around a frozen base: compute once what the whole update needs."""
        return observation

    def _gaussian(self, observation: Observation) -> tuple[torch.Tensor, torch.Tensor]:
        with autocast(self.device, self.precision):
            return self.actor(observation)

    def _normalized_values(self, observation: Observation) -> torch.Tensor:
        if self.critic.reads_base_code and observation.base_code is None:
            observation = self._remembering(observation)
        with autocast(self.device, self.precision):
            return self.critic(observation)

    def _normalizers(self) -> Iterator[RunningNormalizer]:
        """Those that learn while samples are collected."""
        yield from (*self.actor.normalizers(), *self.critic.normalizers())

    @torch.no_grad()
    def _observe(self, observation: Observation) -> None:
        """Collect input statistics; they act from the next rollout on."""
        moments = moments_of(observation.frames)
        for normalizer in self._normalizers():
            normalizer.observe(moments)

    @property
    def knows_nothing(self) -> bool:
        """Whether a normaliser of its inputs has yet to see the first one."""
        return any(bool(normalizer.count == 0) for normalizer in self._normalizers())

    def learn_statistics(self, obs: PyTorchObs) -> None:
        """Collect the input statistics of observations (B, 784), and use them from now on."""
        self._observe(self._split(obs))
        for normalizer in self._normalizers():
            normalizer.apply_statistics()

    def expect(self, frames: torch.Tensor) -> None:
        """Let states to come (B, 780), or single frames (B, 195), count as much as all that was collected until now.

        What is far from all of that would be clipped, and clipped numbers tell nothing and have no gradient.
        """
        moments = moments_of(frames.reshape(len(frames), -1, self.architecture.frame_size))
        for normalizer in self._normalizers():
            normalizer.observe(moments._replace(samples=max(1, int(normalizer.count))))
            normalizer.apply_statistics()

    def forward(self, obs: PyTorchObs, deterministic: bool = False) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Act while samples are collected.

        Args:
            obs: observations (B, 784), or a dict of them and heightmaps (B, 1, 35, 35).
            deterministic: take the mean.

        Returns:
            Actions (B, n), values (B, K) in real units, log-probabilities (B,).

        Raises:
            RuntimeError: if the policy was loaded with several objectives and nobody set them again.
        """
        if self.num_objectives > 1 and not self._objectives_set:
            raise RuntimeError(
                f"this model learned with {self.num_objectives} objectives: pass DiscriminatorRewardCallback to learn()"
            )
        observation = self._remembering(self._split(obs))
        self.remembered = observation.remembered()
        self._rollout_length.add(len(observation.goal))
        self._observe(observation)
        distribution = self._distribution(observation)
        actions = distribution.get_actions(deterministic=deterministic)
        values = self.value_norm.denormalize(self._normalized_values(observation))
        return actions, values, distribution.log_prob(actions)

    def _distribution(self, observation: Observation) -> DiagGaussianDistribution:
        mean, log_std = self._gaussian(observation)
        return DiagGaussianDistribution(self.architecture.action_size).proba_distribution(mean, log_std)

    def get_distribution(self, obs: PyTorchObs) -> DiagGaussianDistribution:
        """The Gaussian over actions, given observations."""
        return self._distribution(self._split(obs))

    def evaluate_actions(
        self, obs: PyTorchObs, actions: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Values (B, K) in normalised units, log-probabilities (B,) and entropies (B,), for PPO's loss."""
        observation = self._split(obs)
        distribution = self._distribution(observation)
        entropy = distribution.distribution.entropy().sum(dim=1)
        return self._normalized_values(observation), distribution.log_prob(actions), entropy

    def predict_objective_values(self, obs: PyTorchObs) -> torch.Tensor:
        """Values (B, K) in real units."""
        return self.value_norm.denormalize(self._normalized_values(self._split(obs)))

    def predict_values(self, obs: PyTorchObs) -> torch.Tensor:
        """Weighted sum of the objectives' values (B, 1) in real units, what SB3 bootstraps with."""
        values = self.predict_objective_values(obs)
        return (values * values.new_tensor(self.objective_weights)).sum(dim=1, keepdim=True)

    def set_training_mode(self, mode: bool) -> None:
        """Switch between updating and collecting; collecting begins with the statistics collected so far."""
        self.precision = use_precision(self.requested_precision, self.device)
        if self.training and not mode:
            for normalizer in self._normalizers():
                normalizer.apply_statistics()
        if mode:
            self._rollout_length.start_again()
        super().set_training_mode(mode)

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return super()._get_constructor_parameters() | {"precision": self.requested_precision}
