"""The policy that trains a base."""

from collections.abc import Mapping
from typing import Any

from gymnasium import spaces
from stable_baselines3.common.type_aliases import Schedule
from torch import nn

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.backbone import INITIAL_STD, Backbone
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.policies.space_contract import mean_pose
from sb3_adaptnet.weights.checkpoint import BASE


class PretrainPolicy(ObjectivePolicy):
    """Trains a base from nothing; also the paper's baseline "Scratch" (sec. 8.1).

    Attributes:
        actor: the network, which `save_base` exports.
    """

    actor: Backbone

    def __init__(
        self,
        observation_space: spaces.Space,
        action_space: spaces.Space,
        lr_schedule: Schedule,
        gru_size: int = 256,
        hidden_sizes: tuple[int, ...] = (1024, 512),
        initial_std: float = INITIAL_STD,
        learn_std: bool = True,
        use_sde: bool = False,
        **settings: Any,
    ) -> None:
        """Build a fresh network, whose first actions are the clips' mean pose.

        Args:
            observation_space: see `ObjectivePolicy`, as the next two.
            action_space: carries `joint_names` and `mean_pose`.
            lr_schedule: PPO's learning rate.
            gru_size: width of the state encoder (the paper's: 256).
            hidden_sizes: widths of the fully connected layers (the paper's: 1024, 512).
            initial_std: standard deviation of the first actions, in the units of actions (the range is [-1, 1]).
            learn_std: whether the standard deviation learns, or stays `initial_std`. Where it learned, it shrank from
                0.067 to 0.040 within 2.2 M samples of the walk, and the steps that the KL divergence allows with it.
            use_sde: not supported.
            **settings: precision, actor_lr, critic_lr, critic, optimizer_class, optimizer_kwargs of `ObjectivePolicy`.

        Raises:
            ValueError: for an `initial_std` that is not positive; otherwise as `ObjectivePolicy`.
        """
        if not initial_std > 0:
            raise ValueError(f"initial_std must be above 0, not {initial_std!r}")
        super().__init__(observation_space, action_space, lr_schedule, use_sde, **settings)
        architecture = Architecture(
            self.joints, gru_size=gru_size, hidden_sizes=tuple(hidden_sizes), heightmap=self.reads_heightmap
        )
        actor = Backbone(architecture)
        actor.start_at(mean_pose(action_space).tolist(), initial_std)
        if not learn_std:
            actor.hold_std()
        self.assemble(actor)

    def describe_actor(self) -> dict[str, Any]:
        """The sizes, and whether the standard deviation learns."""
        return {"architecture": self.architecture.to_dict(), "learn_std": self.actor.learns_std}

    def actor_from(self, description: Mapping[str, Any]) -> Actor:
        """A network as described."""
        actor = Backbone(Architecture.from_dict(description["architecture"]))
        if not description.get("learn_std", True):
            actor.hold_std()
        return actor

    def export(self) -> tuple[str, nn.Module, dict[str, Any]]:
        """The whole network, as a base."""
        return BASE, self.actor, {"architecture": self.architecture.to_dict(), "method": "pretrain"}
