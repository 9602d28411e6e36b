"""The policy network that is pretrained and then frozen (paper, fig. 6a)."""

import math
from collections.abc import Sequence
from dataclasses import replace

import torch
from torch import nn
from torch.nn import functional

from sb3_adaptnet.modules.actor import Actor
from sb3_adaptnet.modules.architecture import Architecture
from sb3_adaptnet.modules.encoder import StateEncoder
from sb3_adaptnet.modules.heightmap import CODE_SIZE, HeightmapEncoder, require_heightmap
from sb3_adaptnet.modules.layers.normalizer import RunningNormalizer
from sb3_adaptnet.modules.observation import Observation

INITIAL_STD = 0.067
"""Standard deviation of the first actions, in [-1, 1]: enough to explore, little enough to stay on the feet."""
HEAD_GAIN = 0.01
"""Orthogonal gain of the mean head: the first actions are the mean pose."""
LOG_STD_LIMITS = (-5.0, 1.0)
"""Bounds of the log standard deviation, which keep its exponential finite whatever the optimiser does."""
_HEADS = ("mean.", "log_std.")
"""What the names of the heads' parameters begin with."""


def make_hidden_layers(sizes: Sequence[int]) -> nn.ModuleList:
    """Fully connected layers between latent spaces of the given widths, orthogonal with gain sqrt(2)."""
    layers = [nn.Linear(inputs, outputs) for inputs, outputs in zip(sizes[:-1], sizes[1:], strict=True)]
    for layer in layers:
        nn.init.orthogonal_(layer.weight, gain=math.sqrt(2.0))
        nn.init.zeros_(layer.bias)
    return nn.ModuleList(layers)


def log_factor(noise: float) -> float:
    """What a factor on standard deviations adds to their logarithm.

    Raises:
        ValueError: if it is not above 0.
    """
    if not 0.0 < noise < math.inf:
        raise ValueError(f"noise is a factor above 0, not {noise}")
    return math.log(noise)


class Backbone(Actor):
    """Normaliser, GRU, fully connected layers with ReLU6, and two linear heads.

    Attributes:
        architecture: the sizes.
        normalizer: statistics of one frame.
        encoder: state encoder E (frames to gru_size numbers).
        layers: Z0 -> Z1 -> Z2; the activation follows each.
        mean, log_std: heads on the last latent space.
        heightmap, heightmap_projection: optional encoder G and its linear map into the first layer, which equals
            concatenating the code to Z0 but leaves Z0's width the same with and without a heightmap.
    """

    def __init__(self, architecture: Architecture) -> None:
        super().__init__()
        self.architecture = architecture
        self.normalizer = RunningNormalizer(architecture.frame_size)
        self.encoder = StateEncoder(architecture.frame_size, architecture.gru_size)
        self.layers = make_hidden_layers(architecture.latent_sizes)
        self.mean = nn.Linear(architecture.latent_sizes[-1], architecture.action_size)
        self.log_std = nn.Linear(architecture.latent_sizes[-1], architecture.action_size)
        self.heightmap = HeightmapEncoder() if architecture.heightmap else None
        self.heightmap_projection = (
            nn.Linear(CODE_SIZE, architecture.hidden_sizes[0], bias=False) if architecture.heightmap else None
        )
        self._initialise_heads()

    def _initialise_heads(self) -> None:
        nn.init.orthogonal_(self.mean.weight, gain=HEAD_GAIN)
        nn.init.zeros_(self.mean.bias)
        nn.init.orthogonal_(self.log_std.weight, gain=HEAD_GAIN)
        nn.init.constant_(self.log_std.bias, math.log(INITIAL_STD))

    @torch.no_grad()
    def start_at(self, pose: Sequence[float], std: float = INITIAL_STD) -> None:
        """Start the actions around a pose (action_size,), given as an action in [-1, 1], with a standard deviation."""
        self.mean.bias.copy_(torch.as_tensor(pose, dtype=self.mean.bias.dtype))
        self.log_std.bias.fill_(math.log(std))

    @torch.no_grad()
    def hold_std(self) -> None:
        """Make the standard deviation the same in every state, where it starts, and keep it from learning."""
        self.log_std.weight.zero_()
        self.log_std.requires_grad_(False)

    @torch.no_grad()
    def scale_std(self, noise: float) -> None:
        """Multiply the standard deviations by a factor.

        Raises:
            ValueError: if it is not above 0.
        """
        self.log_std.bias.add_(log_factor(noise))

    @property
    def learns_std(self) -> bool:
        """Whether the standard deviation learns."""
        return self.log_std.weight.requires_grad

    def code(self, frames: torch.Tensor) -> torch.Tensor:
        """The state code E(o) of frames, (B, gru_size), float32."""
        return self.encoder(self.normalizer(frames)).float()

    def encode(self, observation: Observation) -> torch.Tensor:
        """The latent z0 = [E(o), g], (B, gru_size + goal_size); the goal is not normalised."""
        return torch.cat((self.code(observation.frames), observation.goal), dim=1)

    def first_bias(self, observation: Observation) -> torch.Tensor | None:
        """What the heightmap adds to the first layer's output, (B, hidden_sizes[0]), or None without one."""
        if self.heightmap is None or self.heightmap_projection is None:
            return None
        return self.heightmap_projection(self.heightmap(require_heightmap(observation.heightmap)))

    def latents(self, observation: Observation) -> list[torch.Tensor]:
        """All latents [z0, z1, ..., zn], the hidden ones after their activation."""
        latents = [self.encode(observation)]
        extra = self.first_bias(observation)
        for layer in self.layers:
            output = layer(latents[-1])
            latents.append(functional.relu6(output if extra is None else output + extra))
            extra = None
        return latents

    def heads(self, latent: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log standard deviation (B, action_size) of the action; always in float32."""
        with torch.autocast(latent.device.type, enabled=False):
            latent = latent.float()
            return self.mean(latent), self.log_std(latent).clamp(*LOG_STD_LIMITS)

    def forward(self, observation: Observation) -> tuple[torch.Tensor, torch.Tensor]:
        """Mean and log standard deviation (B, action_size) of the Gaussian over actions (paper, sec. 3)."""
        return self.heads(self.latents(observation)[-1])

    def normalizers(self) -> list[RunningNormalizer]:
        """The network's own normaliser."""
        return [self.normalizer]

    def with_joints(self, joints: Sequence[str]) -> "Backbone":
        """A copy for a character that has only some of the joints: the other joints' output rows are dropped.

        Args:
            joints: names of the joints, in the order of the new outputs.

        Returns:
            A new network whose outputs equal this one's at the named joints.

        Raises:
            ValueError: for a joint that this network does not drive.
        """
        unknown = [name for name in joints if name not in self.architecture.joints]
        if unknown:
            raise ValueError(f"base has no outputs for joints {unknown}; it drives {list(self.architecture.joints)}")
        rows = [self.architecture.joints.index(name) for name in joints]
        pruned = Backbone(replace(self.architecture, joints=tuple(joints)))
        state = {name: t[rows] if name.startswith(_HEADS) else t for name, t in self.state_dict().items()}
        pruned.load_state_dict(state)
        return pruned
