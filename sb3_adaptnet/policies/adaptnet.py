"""AdaptNet as a Stable-Baselines3 policy."""

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from torch import nn

from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.adaptation.adapted import AdaptedActor, Penalties
from sb3_adaptnet.modules.adaptation.companions import Companions
from sb3_adaptnet.modules.adaptation.merge import merge
from sb3_adaptnet.modules.architecture import AdaptationShape, Architecture, CriticShape
from sb3_adaptnet.modules.backbone import Backbone
from sb3_adaptnet.modules.layers.precision import autocast
from sb3_adaptnet.modules.observation import Observation
from sb3_adaptnet.policies.from_base import PolicyFromBase
from sb3_adaptnet.policies.frozen import frozen
from sb3_adaptnet.policies.space_contract import companions_in
from sb3_adaptnet.weights.checkpoint import (
    ADAPTATION,
    AdaptationFile,
    read_adaptation,
    resolve,
)

TRAINED = "main"
"""Name of the adaptation that a policy trains."""


class AdaptNetPolicy(PolicyFromBase):
    """AdaptNet: a frozen base, an injector into its latents, adaptors at its layers (paper, secs. 4 and 5).

    At the start it acts exactly as its base. `alpha` may be set at any time (0 is the base, 1 the adapted policy);
    further adaptations of the same base may be added and blended.
    """

    actor: AdaptedActor

    def __init__(
        self,
        *args: Any,
        injection: str = "z0",
        own_encoder: bool = True,
        adaptors: str | None = "full",
        rank: int = 64,
        injector: bool = True,
        beta: float = 0.01,
        kappa: float = 0.01,
        alpha: float = 1.0,
        noise: float = 1.0,
        start: str | Path | None = None,
        companions: Sequence[str | Path] = (),
        companion_kl: float | None = 5.0,
        **settings: Any,
    ) -> None:
        """Read the base and add an adaptation that does nothing yet, or does what another one does.

        Args:
            *args: spaces and PPO's learning rate; see `PolicyFromBase`.
            injection: latent space that is injected: "z0" (the paper's choice), "z1", "z2" or "all".
            own_encoder: whether the injector has its own state encoder.
            adaptors: "full", "lora" or None.
            rank: rank of "lora" adaptors.
            injector: whether there is an injector.
            beta: coefficient of the injection's norm (eq. 12).
            kappa: coefficient of the adaptors' norm (eq. 12).
            alpha: scale of the adaptation.
            noise: factor on the standard deviations of the base's actions, which act while it learns; above 0.
            start: adaptation of the same base to go on from, a shipped one's name or a file; the choices above, up to
                `injector`, are then the file's, and so is whether a heightmap is read: with one that reads none, the
                adaptation stays blind, which a warning says. The training must be gentle with it, as `adaptnet train
                --start` is: PPO with an `actor_lr` of 1e-6 at first, SVG without `regression_updates`.
            companions: further adaptations of the base, names or files, frozen, of which the k-th acts in the worlds
                whose observations say k, as those of `JoinedWorlds` do: what learns beside them can be stacked.
            companion_kl: how far the actions may be from what base and companion do alone, at no cost [nat]; also in
                worlds without a companion. None for no bound.
            **settings: base of `PolicyFromBase`; precision, actor_lr, critic_lr, critic, optimizer_class,
                optimizer_kwargs of `ObjectivePolicy`.

        Raises:
            ValueError: for an unknown choice, a negative penalty, if there would be nothing to train, or if the
                observations tell another number of companions apart.
            CheckpointError: if base, start or a companion cannot be read, or adapts another base. A base's or start's
                file that is missing only fails when the policy first acts, as in `PolicyFromBase`.
        """
        if not injector and adaptors is None:
            raise ValueError("injector=False and adaptors=None leave nothing to train; switch one of them on")
        self._shape = AdaptationShape(injection, own_encoder, adaptors, rank, injector)
        self._penalties, self._noise, self._companions = Penalties(beta, kappa, companion_kl), float(noise), companions
        self.merged = False
        super().__init__(*args, **settings)
        self.alpha = alpha
        self.keeps_statistics = start is not None
        if start is not None:
            self._go_on_from(start)
        known, given = companions_in(self.observation_space), len(companions)
        if known != given:
            raise ValueError(f"there are {given} companions, but observations tell {known} apart: see JoinedWorlds")
        if companions:
            self.actor.companions = Companions([self._frozen(read_adaptation(name)) for name in companions])

    def _critic_shape(self, wanted: CriticShape) -> CriticShape:
        return wanted

    def adapt(self, base: Backbone) -> AdaptedActor:
        """The base with an adaptation that does nothing yet."""
        shape = replace(self._shape, heightmap=self.reads_heightmap and self._shape.injector)
        adaptation = Adaptation(base.architecture, shape)
        adaptation.start_from(base)
        return AdaptedActor(base, {TRAINED: adaptation}, self._penalties, self._noise)

    def _go_on_from(self, start: str | Path) -> None:
        if resolve(start).is_file():
            self.load_adaptation(start)
            if self.reads_heightmap and not self.actor.parts()[TRAINED].shape.heightmap:
                found = f"{str(start)!r} reads no heightmap"
                warnings.warn(f"{found}, and what goes on from it will not either", stacklevel=4)
        else:  # `PPO.load` builds the policy before it restores it
            self.miss(f"there is no file {str(start)!r} of an adaptation to start from")

    def _remembering(self, observation: Observation) -> Observation:
        with autocast(self.device, self.precision):
            return self.actor.remembering(observation)

    # -- run time (paper, sec. 8.1) ----------------------------------------------------------------------------------

    @property
    def alpha(self) -> float:
        """Scale of the adaptation: 0 is the base, 1 the adapted policy; any finite number."""
        return self.actor.alpha

    @alpha.setter
    def alpha(self, value: float) -> None:
        if not math.isfinite(value):
            raise ValueError(f"alpha must be a finite number, not {value}")
        if self.merged and value != self.actor.alpha:
            raise ValueError(f"the adaptors are merged at alpha = {self.actor.alpha}, which can no longer change")
        self.actor.alpha = float(value)

    @property
    def weights(self) -> dict[str, float]:
        """Weight of each adaptation in the blend; the one that is trained is called "main"."""
        return dict(self.actor.weights)

    def blend(self, weights: Mapping[str, float]) -> None:
        """Set the adaptations' weights, such as {"stoop": 0.3, "limp": 0.7}; those not named get 0.

        Raises:
            ValueError: for an unknown name, a weight that is not finite, or a merged policy.
        """
        self._refuse_if_merged("blend")
        self.actor.blend(weights)

    def add_adaptation(self, name_or_file: str | Path, name: str | None = None, weight: float = 0.0) -> str:
        """Add another adaptation of the same base, frozen.

        Args:
            name_or_file: name of a shipped adaptation, or a file.
            name: what to call it in `blend`; None takes the file's stem.
            weight: its weight at first.

        Returns:
            Its name.

        Raises:
            CheckpointError: if it cannot be read or adapts another base.
            ValueError: if the name is taken, or for a merged policy.
        """
        self._refuse_if_merged("add an adaptation")
        read = read_adaptation(name_or_file)
        name = (name or read.file.stem).replace(".", "_")  # torch allows no dots in module names
        if name in self.actor.adaptations:
            raise ValueError(f"there is an adaptation {name!r} already; this policy has {list(self.actor.adaptations)}")
        self.actor.adaptations[name] = self._frozen(read).to(self.device)
        self.actor.weights[name] = float(weight)
        return name

    def _frozen(self, read: AdaptationFile) -> Adaptation:
        return frozen(read, self.base_name, self.base_hash, self.architecture, self.reads_heightmap)

    def load_adaptation(self, name_or_file: str | Path) -> None:
        """Replace the weights (and the shape) of the trained adaptation by those of a file.

        Raises:
            CheckpointError: if it cannot be read or adapts another base.
        """
        self._refuse_if_merged("load an adaptation")
        before = self.actor.adaptations.pop(TRAINED)
        try:
            self.add_adaptation(name_or_file, TRAINED, weight=1.0)
        except Exception:
            self.actor.adaptations[TRAINED] = before
            raise
        self.actor.adaptations[TRAINED].requires_grad_(True)
        self._make_optimizer()

    def merge(self) -> None:
        """Fold the adaptors, at the present alpha and weights, into the layers; actions stay equal to 1e-5.

        For running only: afterwards alpha and the blend are fixed, and the adaptation can no longer be saved.
        """
        self._refuse_if_merged("merge again")
        self.actor = merge(self.actor).requires_grad_(False)
        self.merged = True

    def _refuse_if_merged(self, wish: str) -> None:
        if self.merged:
            raise ValueError(f"cannot {wish}: this policy's adaptors are merged into its layers")

    # -- saving and loading ------------------------------------------------------------------------------------------

    def describe_actor(self) -> dict[str, Any]:
        """Base, and the shape of every adaptation."""
        shapes = {name: part.shape.to_dict() for name, part in self.actor.parts().items()}
        return super().describe_actor() | {"adaptations": shapes, "merged": self.merged}

    def actor_from(self, description: Mapping[str, Any]) -> AdaptedActor:
        """Base and adaptations of the described shapes."""
        base = Backbone(Architecture.from_dict(description["architecture"]))
        self.merged = description["merged"]
        adaptations = {}
        for name, values in description["adaptations"].items():
            adaptation = Adaptation(base.architecture, AdaptationShape.from_dict(values))
            adaptations[name] = adaptation.requires_grad_(name == TRAINED and not self.merged)
        actor = AdaptedActor(base, adaptations, self._penalties, self._noise)
        actor.companions = self.actor.companions
        return actor

    def runtime(self) -> dict[str, Any]:
        """Alpha and the blend's weights."""
        return {"alpha": self.actor.alpha, "weights": self.actor.weights}

    def set_runtime(self, values: Mapping[str, Any]) -> None:
        """Restore alpha and the blend's weights."""
        self.actor.alpha, self.actor.weights = values["alpha"], dict(values["weights"])

    def _get_constructor_parameters(self) -> dict[str, Any]:
        given = {"noise": self._noise, "companions": [str(name) for name in self._companions]}
        return super()._get_constructor_parameters() | self._penalties._asdict() | given

    def export(self) -> tuple[str, nn.Module, dict[str, Any]]:
        """The trained adaptation, without its base."""
        self._refuse_if_merged("save the adaptation")
        adaptation = self.actor.parts()[TRAINED]
        card = super().describe_actor() | {"method": "adaptnet", "shape": adaptation.shape.to_dict()}
        return ADAPTATION, adaptation, card
