"""A policy's networks and optimiser: put together, described in the state dict, and rebuilt from there."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.type_aliases import Schedule

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.architecture import OF_BASE, OWN, Architecture, CriticShape
from sb3_adaptnet.modules.critic import Critic
from sb3_adaptnet.modules.layers.popart import PopArtHead
from sb3_adaptnet.policies.optimizer_groups import ACTOR, CRITIC, keep_moments, make_groups
from sb3_adaptnet.policies.scaled_adam import ScaledAdam
from sb3_adaptnet.policies.self_describing import SelfDescribing, pack, unpack
from sb3_adaptnet.policies.space_contract import action_joints, check_network_fits, has_heightmap

_ADAM = {"eps": 1e-5, "fused": True}
"""Adam's arguments: eps as in SB3's own policies; one kernel for all parameters."""


class AssembledPolicy(SelfDescribing, ActorCriticPolicy):
    """An actor, a critic with K values and one optimiser for both.

    The state dict carries a description of the networks, so that `PPO.load` can rebuild them, whatever the files were
    that they came from. How it acts is `ObjectivePolicy`'s matter.

    Attributes:
        joints: names of the actuated joints, in the order of the actions.
        reads_heightmap: whether observations come with a heightmap.
        critic_shape: what the critic is made of.
        actor: observation -> (mean, log_std).
        critic: observation -> normalised values (B, K).
        objective_weights: weight of each objective in `predict_values`.
    """

    actor: Actor
    critic: Critic
    optimizer: torch.optim.Optimizer

    def __init__(
        self,
        observation_space: spaces.Space,
        action_space: spaces.Space,
        lr_schedule: Schedule,
        actor_lr: float | None = None,
        critic_lr: float | None = None,
        critic: Mapping[str, Any] | None = None,
        optimizer_class: type[torch.optim.Optimizer] = ScaledAdam,
        optimizer_kwargs: dict[str, Any] | None = None,
    ) -> None:
        """Read the spaces; the networks come with `assemble`. The arguments are explained at `ObjectivePolicy`."""
        self.joints = action_joints(action_space)
        self.reads_heightmap = has_heightmap(observation_space)
        super().__init__(
            observation_space,
            action_space,
            lr_schedule,
            optimizer_class=optimizer_class,
            optimizer_kwargs=_ADAM | (optimizer_kwargs or {}),
        )
        self.critic_shape = self._critic_shape(_shape_of(critic or {}))
        self._step_sizes = {ACTOR: actor_lr, CRITIC: critic_lr}
        self._learning_rate = float(lr_schedule(1))
        self.objective_weights: tuple[float, ...] = (1.0,)
        self._objectives_set = False  # by the callback of this training; a loaded model only remembers its weights

    def _build(self, lr_schedule: Schedule) -> None:
        """Nothing: SB3 would build its own networks here, before this class knows its arguments."""

    def _critic_shape(self, wanted: CriticShape) -> CriticShape:
        """The critic's shape, refused where no frozen base's code is remembered that it could read."""
        if wanted.encoder == OF_BASE:
            raise ValueError(
                f"{type(self).__name__} remembers no frozen base's code: its critic's encoder must be {OWN!r}"
            )
        return wanted

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

    def assemble(self, actor: Actor) -> None:
        """Put in an actor, a fresh critic of its sizes and an optimiser for both."""
        self.actor = actor
        check_network_fits(self.architecture, self.observation_space)
        self.critic = Critic(self.architecture, self.reads_heightmap, len(self.objective_weights), self.critic_shape)
        self._make_optimizer()

    def _make_optimizer(self) -> None:
        groups = make_groups({ACTOR: self.actor, CRITIC: self.critic}, self._step_sizes, self._learning_rate)
        make: Callable[..., torch.optim.Optimizer] = self.optimizer_class  # the classes differ in their arguments
        self.optimizer = make(groups, lr=self._learning_rate, **self.optimizer_kwargs)

    def set_objectives(self, weights: Sequence[float]) -> None:
        """Give the critic one output per weight; a changed number means a fresh head, for the optimiser, too.

        Raises:
            ValueError: if there are no weights.
        """
        if len(weights) == 0:
            raise ValueError("set_objectives needs at least one weight")
        changed = len(weights) != self.num_objectives
        self.objective_weights, self._objectives_set = tuple(float(weight) for weight in weights), True
        if changed:
            self.critic.set_objectives(len(weights))
            before = self.optimizer
            self._make_optimizer()
            keep_moments(self.optimizer, before)

    @property
    def num_objectives(self) -> int:
        """Number of objectives K."""
        return len(self.objective_weights)

    @property
    def value_norm(self) -> PopArtHead:
        """Statistics of the K returns: `update`, `normalize`, `denormalize`."""
        return self.critic.head

    def describe(self) -> dict[str, Any]:
        """The actor's shape, and what of the policy is no tensor."""
        return {
            "actor": self.describe_actor(),
            "critic": self.critic_shape.to_dict(),
            "runtime": self.runtime(),
            "objective_weights": self.objective_weights,
            "training": self.training,
        }

    def become(self, description: Mapping[str, Any]) -> None:
        """Rebuild the networks if the description is another one's, and take over the rest."""
        current = unpack(pack(self.describe_actor()))
        device, old_shape = self.device, self.critic_shape
        self.objective_weights, old = tuple(description["objective_weights"]), self.num_objectives
        self.critic_shape = CriticShape.from_dict(description.get("critic", {}))
        if description["actor"] != current or self.critic_shape != old_shape:
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
        }


def _shape_of(critic: Mapping[str, Any]) -> CriticShape:
    known = [field.name for field in fields(CriticShape)]
    unknown = [name for name in critic if name not in known]
    if unknown:
        raise ValueError(f"a critic's settings are {known}, not {unknown}")
    return CriticShape.from_dict(critic)
