"""What every policy of this package shares: K values, precision, normalisers, a state dict that describes itself."""

import json
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.distributions import DiagGaussianDistribution
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.type_aliases import PyTorchObs, Schedule

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.critic import Critic
from sb3_adaptnet.modules.layers.normalizer import moments_of
from sb3_adaptnet.modules.layers.popart import PopArtHead
from sb3_adaptnet.modules.layers.precision import PRECISIONS, autocast, use_precision
from sb3_adaptnet.modules.observation import Observation, split_observation
from sb3_adaptnet.policies.scaled_adam import ScaledAdam
from sb3_adaptnet.policies.space_contract import action_joints, has_heightmap

LONGEST_ROLLOUT = 65_536  # samples; beyond this an update is rare and its buffer takes gigabytes
_EXTRA = "_extra_state"  # torch's key for what get_extra_state returns
_ADAM = {"eps": 1e-5, "fused": True}  # eps as in SB3's own policies; one kernel for all parameters


class ObjectivePolicy(ActorCriticPolicy):
    """An actor and a critic with K objectives, for stock `PPO`.

    Without the callback K is 1 and values are plain numbers. `set_objectives` gives the critic K outputs with running
    statistics (PopArt): `forward` then returns values (B, K) in real units, `evaluate_actions` normalised ones, and
    `predict_values` their weighted sum (B, 1).

    The policy's state dict carries a description of its networks, so that `PPO.load` can rebuild them, whatever the
    files were that they came from.

    Attributes:
        actor: observation -> (mean, log_std).
        critic: observation -> normalised values (B, K).
        objective_weights: weight of each objective in `predict_values`.
        base_code: (B, gru_size) what a frozen base made of the last `forward`, or None. A buffer may hand
            it back, as "base_code" beside "observation", to `evaluate_actions`, which then need not encode again.
        precision: the precision in use: "fp32", "medium" or "bf16".
    """

    actor: Actor
    critic: Critic
    optimizer: torch.optim.Optimizer

    def __init__(
        self,
        observation_space: spaces.Space,
        action_space: spaces.Space,
        lr_schedule: Schedule,
        use_sde: bool = False,
        precision: str = "fp32",
        actor_lr: float | None = None,
        critic_lr: float | None = None,
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
            optimizer_class: an optimiser that honours each group's "lr_scale".
            optimizer_kwargs: further arguments of the optimiser.

        Raises:
            ValueError: for spaces without what the policy needs, an unknown precision, or use_sde.
        """
        if use_sde:
            raise ValueError("use_sde=True is not supported: the standard deviation is a head of the network")
        if precision not in (*PRECISIONS, "auto"):
            raise ValueError(f"precision must be one of {[*PRECISIONS, 'auto']}, not {precision!r}")
        self.joints = action_joints(action_space)
        self.reads_heightmap = has_heightmap(observation_space)
        super().__init__(
            observation_space,
            action_space,
            lr_schedule,
            optimizer_class=optimizer_class,
            optimizer_kwargs=_ADAM | (optimizer_kwargs or {}),
        )
        self.requested_precision = precision
        self.precision = use_precision(precision)
        self._rates = {"actor": actor_lr, "critic": critic_lr}
        self._learning_rate = float(lr_schedule(1))
        self.objective_weights: tuple[float, ...] = (1.0,)
        self._objectives_set = False  # by the callback of this training; a loaded model only remembers its weights
        self.base_code: torch.Tensor | None = None
        self._collected = 0  # samples since the last update

    def _build(self, lr_schedule: Schedule) -> None:
        """Nothing: SB3 would build its own networks here, before this class knows its arguments."""

    # -- for subclasses ----------------------------------------------------------------------------------------------

    def describe_actor(self) -> dict[str, Any]:
        """JSON values from which `actor_from` builds an actor of the same shape."""
        raise NotImplementedError

    def actor_from(self, description: Mapping[str, Any]) -> Actor:
        """An actor of the described shape; its weights are about to be loaded."""
        raise NotImplementedError

    @property
    def architecture(self) -> Architecture:
        """Sizes of the policy network."""
        return self.actor.architecture

    def runtime(self) -> dict[str, Any]:
        """JSON values that may change while the policy runs, and do not change its networks' shapes."""
        return {}

    def set_runtime(self, values: Mapping[str, Any]) -> None:
        """Restore what `runtime` gave."""

    # -- assembly ----------------------------------------------------------------------------------------------------

    def assemble(self, actor: Actor) -> None:
        """Put in an actor, a fresh critic of its sizes and an optimiser for both."""
        self.actor = actor
        self._check_sizes()
        self.critic = Critic(self.architecture, self.reads_heightmap, len(self.objective_weights))
        self._make_optimizer()

    def _check_sizes(self) -> None:
        space = self.observation_space
        shape = space["observation"].shape if isinstance(space, spaces.Dict) else space.shape
        if shape != (self.architecture.observation_size,):
            raise ValueError(
                f"observations have shape {shape}, but the network reads ({self.architecture.observation_size},)"
            )
        if self.architecture.heightmap and not self.reads_heightmap:
            raise ValueError(f"the network reads a heightmap, but the observation space {space} has none")

    def _make_optimizer(self) -> None:
        """Two groups, "actor" and "critic"; `lr_scale` survives SB3's overwriting of `lr`."""
        groups = []
        for name, network in (("actor", self.actor), ("critic", self.critic)):
            rate = self._rates[name]
            scale = 1.0 if rate is None or self._learning_rate == 0 else rate / self._learning_rate
            parameters = [p for p in network.parameters() if p.requires_grad]
            groups.append({"name": name, "params": parameters, "lr_scale": scale})
        self.optimizer = self.optimizer_class(groups, lr=self._learning_rate, **self.optimizer_kwargs)  # type: ignore

    def set_objectives(self, weights: Sequence[float]) -> None:
        """Give the critic one output per weight; a changed number means a fresh head and a fresh optimiser.

        Raises:
            ValueError: if there are no weights.
        """
        if len(weights) == 0:
            raise ValueError("set_objectives needs at least one weight")
        changed = len(weights) != self.num_objectives
        self.objective_weights, self._objectives_set = tuple(float(weight) for weight in weights), True
        if changed:
            self.critic.set_objectives(len(weights))
            self._make_optimizer()

    @property
    def num_objectives(self) -> int:
        """Number of objectives K."""
        return len(self.objective_weights)

    @property
    def value_norm(self) -> PopArtHead:
        """Statistics of the K returns: `update`, `normalize`, `denormalize`."""
        return self.critic.head

    # -- acting ------------------------------------------------------------------------------------------------------

    def _split(self, obs: PyTorchObs) -> Observation:
        if isinstance(obs, dict):
            heightmap = obs["heightmap"].float() if "heightmap" in obs else None
            parts = split_observation(obs["observation"].float(), self.architecture, heightmap)
            return parts._replace(base_code=obs.get("base_code"))
        return split_observation(obs.float(), self.architecture)

    def _with_base_code(self, observation: Observation) -> Observation:
        """For policies around a frozen base: encode once what the whole update needs."""
        return observation

    def _gaussian(self, observation: Observation) -> tuple[torch.Tensor, torch.Tensor]:
        with autocast(self.device, self.precision):
            return self.actor(observation)

    def _normalized_values(self, observation: Observation) -> torch.Tensor:
        with autocast(self.device, self.precision):
            return self.critic(observation)

    @torch.no_grad()
    def _observe(self, observation: Observation) -> None:
        """Collect input statistics; they act from the next rollout on."""
        moments = moments_of(observation.frames)
        for normalizer in (*self.actor.normalizers(), self.critic.normalizer):
            normalizer.observe(moments)

    def _count(self, samples: int) -> None:
        """Warn once per rollout that it is long; a policy cannot see PPO's n_steps before."""
        before, self._collected = self._collected, self._collected + samples
        if before <= LONGEST_ROLLOUT < self._collected:
            warnings.warn(
                f"more than {LONGEST_ROLLOUT:,} samples without an update: PPO's n_steps x number of environments is "
                f"large; hyperparameters(id) has values that suit many environments, such as n_steps=16 for 512",
                stacklevel=3,
            )

    def forward(  # type: ignore[override]
        self, obs: PyTorchObs, deterministic: bool = False
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
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
        observation = self._with_base_code(self._split(obs))
        self.base_code = observation.base_code
        self._count(len(observation.goal))
        self._observe(observation)
        distribution = self._distribution(observation)
        actions = distribution.get_actions(deterministic=deterministic)
        values = self.value_norm.denormalize(self._normalized_values(observation))
        return actions, values, distribution.log_prob(actions)

    def _distribution(self, observation: Observation) -> DiagGaussianDistribution:
        mean, log_std = self._gaussian(observation)
        return DiagGaussianDistribution(self.architecture.action_size).proba_distribution(mean, log_std)

    def get_distribution(self, obs: PyTorchObs) -> DiagGaussianDistribution:  # type: ignore[override]
        """The Gaussian over actions, given observations."""
        return self._distribution(self._split(obs))

    def evaluate_actions(  # type: ignore[override]
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
            for normalizer in (*self.actor.normalizers(), self.critic.normalizer):
                normalizer.apply_statistics()
        if mode:
            self._collected = 0
        super().set_training_mode(mode)

    # -- saving and loading ------------------------------------------------------------------------------------------

    def get_extra_state(self) -> torch.Tensor:
        """The description of the networks, as JSON in a uint8 tensor; part of the state dict."""
        description = {
            "actor": self.describe_actor(),
            "runtime": self.runtime(),
            "objective_weights": self.objective_weights,
            "training": self.training,
        }
        return torch.frombuffer(bytearray(json.dumps(description, sort_keys=True).encode()), dtype=torch.uint8)

    def set_extra_state(self, state: torch.Tensor) -> None:
        """Nothing: `load_state_dict` has read the description before it loads the weights."""

    def load_state_dict(  # type: ignore[override]
        self, state_dict: Mapping[str, Any], strict: bool = True, assign: bool = False
    ) -> Any:
        """Load weights, after rebuilding the networks if the state's description is another one."""
        described = state_dict.get(_EXTRA)
        if described is not None:
            self._become(json.loads(bytes(described.cpu().tolist())))
        return super().load_state_dict(state_dict, strict=strict, assign=assign)

    def _become(self, description: Mapping[str, Any]) -> None:
        current = json.loads(json.dumps(self.describe_actor()))
        device = self.device
        self.objective_weights, old = tuple(description["objective_weights"]), self.num_objectives
        if description["actor"] != current:
            self.assemble(self.actor_from(description["actor"]))
        elif self.num_objectives != old:
            self.critic.set_objectives(self.num_objectives)
            self._make_optimizer()
        self.set_runtime(description["runtime"])
        self.to(device)
        self.train(description["training"])

    def _get_constructor_parameters(self) -> dict[str, Any]:
        """Arguments for `policy.load`, SB3's own file of a policy alone."""
        return {
            "observation_space": self.observation_space,
            "action_space": self.action_space,
            "lr_schedule": self._dummy_schedule,
            "precision": self.requested_precision,
        }
