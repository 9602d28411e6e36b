"""AdaptNet: a frozen base, one or more adaptations of it, and how much of each acts (paper, secs. 4, 5 and 8.1)."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import NamedTuple, cast

import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.adaptation.adaptation import Adaptation
from sb3_adaptnet.modules.adaptation.companions import ActingCompanions, Companions
from sb3_adaptnet.modules.adaptation.in_part import InPart
from sb3_adaptnet.modules.backbone import Backbone, log_factor
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.layers.regularizers import penalise_distance
from sb3_adaptnet.modules.observation import Observation


class Penalties(NamedTuple):
    """Coefficients of eq. 12: `beta` on the injection's norm, `kappa` on the adaptors' norm.

    `companion_kl` is none: so many nats the actions may differ from what the companions do alone at no cost; None for
    any number of them.
    """

    beta: float = 0.01
    kappa: float = 0.01
    companion_kl: float | None = None

    def checked(self) -> "Penalties":
        """These.

        Raises:
            ValueError: if one is no number, negative or not finite; `companion_kl` may be None.
        """
        for name, value in self._asdict().items():
            optional = name == "companion_kl"
            if not (isinstance(value, int | float) and 0.0 <= value < math.inf or optional and value is None):
                valid = "a finite number that is at least 0" + (", or None" if optional else "")
                raise ValueError(f"{name} must be {valid}, not {value!r}")
        return self


class AdaptedActor(Actor):
    """A frozen base with adaptations, each scaled by alpha times its weight (the interpolation equations of sec. 8.1).

    With one adaptation of weight 1, alpha = 0 is the base and alpha = 1 the adapted policy.

    Attributes:
        base: the frozen network.
        adaptations: name -> adaptation.
        weights: name -> weight in the blend.
        alpha: overall scale.
        penalties: coefficients of eq. 12, used while gradients are computed.
        noise: factor on the base's standard deviations.
        companions: adaptations that act beside these in worlds that name one, or None.
        in_part: the rows of the batches to come in which all adaptations act in part, or None.
    """

    def __init__(
        self,
        base: Backbone,
        adaptations: Mapping[str, Adaptation],
        penalties: Penalties | None = None,
        noise: float = 1.0,
    ) -> None:
        super().__init__()
        self.architecture = base.architecture
        self.base = base.requires_grad_(False)
        self.adaptations = nn.ModuleDict(adaptations)
        self.weights = dict.fromkeys(adaptations, 1.0)
        self.alpha = 1.0
        self.penalties = (penalties or Penalties()).checked()
        self.log_noise = log_factor(noise)
        self.companions: Companions | None = None
        self.in_part: InPart | None = None
        self._layers: list[tuple[torch.Tensor, torch.Tensor]] | None = None  # summed, within `one_update`
        self._passes = 1

    def parts(self) -> dict[str, Adaptation]:
        """The adaptations by name."""
        return {name: cast(Adaptation, module) for name, module in self.adaptations.items()}

    def blend(self, weights: Mapping[str, float]) -> None:
        """Set the weights of the adaptations; those not named get 0.

        Raises:
            ValueError: for an unknown name, or a weight that is not finite.
        """
        unknown = [name for name in weights if name not in self.adaptations]
        if unknown:
            raise ValueError(f"unknown adaptations {unknown}; this policy has {list(self.adaptations)}")
        bad = {name: weight for name, weight in weights.items() if not math.isfinite(weight)}
        if bad:
            raise ValueError(f"weights must be finite numbers, not {bad}")
        self.weights = {name: float(weights.get(name, 0.0)) for name in self.adaptations}

    def active(self) -> list[tuple[float, Adaptation]]:
        """(alpha * weight, adaptation) of every adaptation that acts."""
        scaled = [(self.alpha * self.weights[name], adaptation) for name, adaptation in self.parts().items()]
        return [(scale, adaptation) for scale, adaptation in scaled if scale != 0.0]

    def hidden_layers(self) -> list[tuple[torch.Tensor, torch.Tensor]]:
        """(W + sum of scaled Delta W, b + sum of scaled Delta b) of every hidden layer.

        One product with the summed weights equals the base's plus the adaptors' outputs (eq. 8) and is cheaper.
        """
        if self._layers is not None:
            return self._layers
        base_layers = cast(list[nn.Linear], self.base.layers)
        layers: list[tuple[torch.Tensor, torch.Tensor]] = [(layer.weight, layer.bias) for layer in base_layers]
        for scale, adaptation in self.active():
            for index, (weight, bias) in enumerate(adaptation.increments(self.penalties.kappa)):
                old_weight, old_bias = layers[index]
                layers[index] = (old_weight.add(weight, alpha=scale), old_bias.add(bias, alpha=scale))
        return layers

    @contextmanager
    def one_update(self, passes: int) -> Iterator[None]:
        """Sum the layers once for all `passes`, and penalise the mean of what they inject and do."""
        self._layers, self._passes = self.hidden_layers(), passes
        try:
            yield
        finally:
            self._layers, self._passes = None, 1

    @contextmanager
    def at_strengths(self, strengths: torch.Tensor) -> Iterator[None]:
        """Let the adaptations act in each row of the batches to come at its strength (B,), a factor on alpha."""
        self.in_part = InPart.of(strengths)
        try:
            yield
        finally:
            self.in_part = None

    def injections(self, observation: Observation, base_latent: torch.Tensor) -> dict[int, torch.Tensor]:
        """Latent space index -> sum of the scaled offsets of all active adaptations (eq. 4)."""
        total: dict[int, torch.Tensor] = {}
        beta = self.penalties.beta / self._passes
        for scale, adaptation in self.active():
            for space, offset in adaptation.injections(observation, base_latent, beta).items():
                total[space] = offset * scale if space not in total else total[space].add(offset, alpha=scale)
        if self.in_part is not None:
            total = {space: self.in_part.scaled(offset) for space, offset in total.items()}
        return total

    def base_latent(self, observation: Observation) -> torch.Tensor:
        """The base's z0 = [E(o), g], from the code in the observation if it is there: the base never changes."""
        if observation.base_code is None:
            return self.base.encode(observation)
        return torch.cat((observation.base_code, observation.goal), dim=1)

    def forward(self, observation: Observation) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log standard deviation (B, action_size) of the Gaussian over actions.

        An injection into Z1, Z2, ... is added where the adaptors' increment is: before the activation.
        """
        latent = self.base_latent(observation)
        beside = self._companions_of(observation, latent)
        offsets = self.injections(observation, latent)
        mean, log_std = self._heads(observation, latent, offsets, self.hidden_layers(), beside)
        if beside is None or self.penalties.companion_kl is None or not torch.is_grad_enabled():
            return mean, log_std
        alone = observation.companion_mean
        alone = self.companions_alone(observation) if alone is None else alone
        return penalise_distance(mean, alone, log_std, self.penalties.companion_kl, self._passes), log_std

    def remembering(self, observation: Observation) -> Observation:
        """The observation with what nothing that learns can change: the base's code, and what the companions do."""
        observation = observation._replace(base_code=self.base.code(observation.frames))
        if self.companions is None or observation.companion is None:
            return observation
        offset = self.companions.offsets(observation, self.base_latent(observation))
        observation = observation._replace(companion_offset=offset)
        if self.penalties.companion_kl is None:
            return observation
        return observation._replace(companion_mean=self.companions_alone(observation))

    @torch.no_grad()
    def companions_alone(self, observation: Observation) -> torch.Tensor:
        """Mean action (B, action_size) of the base with each row's companion, without what learns."""
        latent = self.base_latent(observation)
        layers = [(layer.weight, layer.bias) for layer in cast(list[nn.Linear], self.base.layers)]
        return self._heads(observation, latent, {}, layers, self._companions_of(observation, latent))[0]

    def _heads(
        self, observation: Observation, latent: torch.Tensor, offsets: Mapping[int, torch.Tensor],
        layers: Sequence[tuple[torch.Tensor, torch.Tensor]], beside: ActingCompanions | None,
    ) -> tuple[torch.Tensor, torch.Tensor]:  # fmt: skip
        for offset in (offsets.get(0), None if beside is None else beside.offset):
            latent = latent if offset is None else latent + offset
        extra = self.base.first_bias(observation)
        for space, (weight, bias) in enumerate(layers, start=1):
            output = functional.linear(latent, weight, bias)
            if self.in_part is not None:
                output = self.in_part.between(cast(nn.Linear, self.base.layers[space - 1]), latent, output)
            theirs = None if beside is None else beside.output(space, latent, output)
            for term in (extra, offsets.get(space), theirs):
                output = output if term is None else output + term
            latent = functional.relu6(output)
            extra = None
        mean, log_std = self.base.heads(latent)
        return mean, log_std + self.log_noise

    def _companions_of(self, observation: Observation, base_latent: torch.Tensor) -> ActingCompanions | None:
        if self.companions is None or observation.companion is None:
            return None
        return self.companions.acting(observation, base_latent)

    def normalizers(self) -> Sequence[RunningNormalizer]:
        """The normaliser of the injector that learns; the base's and those of other adaptations stay."""
        injectors = [adaptation.injector for adaptation in self.parts().values() if adaptation.trained]
        return [n for injector in injectors if injector is not None for n in injector.normalizers()]
