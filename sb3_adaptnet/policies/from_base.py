"""What AdaptNet and the baselines share: they start from a base."""

import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gymnasium import spaces
from stable_baselines3.common.type_aliases import PyTorchObs

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.adaptation.injector import PRIOR_SAMPLES
from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.observation import Observation
from sb3_adaptnet.policies.objective_policy import ObjectivePolicy
from sb3_adaptnet.policies.space_contract import default_base
from sb3_adaptnet.weights.checkpoint import Base, read_base, resolve
from sb3_adaptnet.weights.weight_file import CheckpointError


class PolicyFromBase(ObjectivePolicy):
    """A policy that starts from a base: reads it, drops the outputs of joints that the character lacks.

    Attributes:
        base_name: name of the base.
        base_hash: hash of its weights, all joints included.
        keeps_statistics: whether the actor's inputs stay normalised as they were. By new statistics what is not zero at
            first, as an adaptation is, would act otherwise before it has learned anything.
    """

    keeps_statistics = False

    def __init__(
        self,
        observation_space: spaces.Space,
        action_space: spaces.Space,
        *args: Any,
        base: str | Path | None = None,
        **settings: Any,
    ) -> None:
        """Read the base and build the networks around it.

        Args:
            observation_space: see `ObjectivePolicy`, as the next two.
            action_space: carries `joint_names`, and `default_base` if no base is given.
            *args: PPO's learning rate, and use_sde, which is not supported.
            base: name of a shipped base, or a file; None takes the environment's default.
            **settings: precision, actor_lr, critic_lr, critic, optimizer_class, optimizer_kwargs of `ObjectivePolicy`.

        Raises:
            CheckpointError: if the base's name is unknown or its file is damaged or foreign. A file that is missing
                only fails when the policy first acts, because `PPO.load` builds the policy before it restores it.
        """
        super().__init__(observation_space, action_space, *args, **settings)
        self.base_argument = default_base(action_space) if base is None else base
        self._missing: CheckpointError | None = None
        found = self._read_base()
        self.base_name, self.base_hash = found.name, found.hash
        self.assemble(self.adapt(found.backbone.with_joints(self.joints)))
        for normalizer in self.critic.normalizers():
            normalizer.start_at(found.backbone.normalizer, PRIOR_SAMPLES)

    def _normalizers(self) -> Iterator[RunningNormalizer]:
        yield from self.critic.normalizers() if self.keeps_statistics else super()._normalizers()

    def _read_base(self) -> Base:
        file = resolve(self.base_argument)
        if file.is_file():
            return read_base(file)
        self.miss(f"there is no base file {str(file)!r}")
        return Base(Backbone(Architecture(self.joints)), file.stem, "", {})

    def miss(self, sentence: str) -> None:
        """Refuse to act, for the reason that the sentence says, until a saved state is loaded."""
        self._missing = CheckpointError(sentence)
        warnings.warn(f"{sentence}; the policy cannot act unless a saved state is loaded into it", stacklevel=5)

    @property
    def lacks_files(self) -> bool:
        """Whether a file that it starts from was missing, and nothing was loaded since."""
        return self._missing is not None

    def check_files_found(self) -> None:
        """Refuse to begin without the files that it starts from.

        Raises:
            CheckpointError: if one was missing and nothing was loaded since.
        """
        if self._missing is not None:
            raise self._missing

    def adapt(self, base: Backbone) -> Actor:
        """The actor at the start of training, made from a base for this character's joints."""
        raise NotImplementedError

    def _split(self, obs: PyTorchObs) -> Observation:
        self.check_files_found()
        return super()._split(obs)

    def describe_actor(self) -> dict[str, Any]:
        """Sizes and identity of the base."""
        return {
            "architecture": self.architecture.to_dict(),
            "base": {"name": self.base_name, "hash": self.base_hash},
        }

    def become(self, description: Mapping[str, Any]) -> None:
        """As any policy, and take over whose base it was: the weights to come bring it along."""
        base = description["actor"]["base"]
        super().become(description)
        self.base_name, self.base_hash, self._missing = base["name"], base["hash"], None

    def _get_constructor_parameters(self) -> dict[str, Any]:
        return super()._get_constructor_parameters() | {"base": str(self.base_argument)}
