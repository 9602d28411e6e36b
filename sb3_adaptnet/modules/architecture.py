"""Sizes of a base network and of an adaptation: plain data that goes into a checkpoint's card."""

from dataclasses import dataclass

from sb3_adaptnet.modules.json_values import JsonValues

OBSERVATION_VERSION = 1
"""Version of what an observation's 784 numbers mean; raised when the environments' layout changes."""
ADAPTORS = ("full", "lora")
"""Kinds of internal adaptors (paper, sec. 4 and 8.3); None stands for no adaptors."""
OWN, OF_BASE = "own", "base"
"""Encoders of a critic: one that learns, or the frozen one of the base that is adapted."""


@dataclass(frozen=True)
class Architecture(JsonValues):
    """Sizes of a policy network (paper, sec. 7 and fig. 6).

    Attributes:
        joints: names of the actuated joints, in the order of the outputs.
        frame_count: body-state frames in an observation, oldest first.
        frame_size: numbers per frame (15 links x 13).
        goal_size: numbers of the goal.
        gru_size: width of the state encoder's hidden state.
        hidden_sizes: widths of the fully connected layers, that is of Z1, Z2, ...
        heightmap: whether the network itself reads a heightmap.
    """

    joints: tuple[str, ...]
    frame_count: int = 4
    frame_size: int = 195
    goal_size: int = 4
    gru_size: int = 256
    hidden_sizes: tuple[int, ...] = (1024, 512)
    heightmap: bool = False

    @property
    def action_size(self) -> int:
        """Number of actions."""
        return len(self.joints)

    @property
    def observation_size(self) -> int:
        """Numbers in a flat observation: all frames, then the goal."""
        return self.frame_count * self.frame_size + self.goal_size

    @property
    def latent_sizes(self) -> tuple[int, ...]:
        """Widths of the latent spaces Z0 (encoder output and goal), Z1, Z2, ..."""
        return (self.gru_size + self.goal_size, *self.hidden_sizes)


@dataclass(frozen=True)
class AdaptationShape(JsonValues):
    """Which parts an adaptation of a base has; the defaults are AdaptNet, the others its ablations (paper, sec. 8).

    Attributes:
        injection: latent space that the injector edits: "z0", "z1", "z2", ... or "all".
        own_encoder: whether the injector has its own state encoder (a copy of the base's).
        adaptors: "full" for full-rank adaptors, "lora" for low-rank ones, None for none.
        rank: rank of the low-rank adaptors.
        injector: whether there is an injector at all.
        heightmap: whether the injector reads a heightmap.
    """

    injection: str = "z0"
    own_encoder: bool = True
    adaptors: str | None = "full"
    rank: int = 64
    injector: bool = True
    heightmap: bool = False

    def __post_init__(self) -> None:
        if self.adaptors is not None and self.adaptors not in ADAPTORS:
            raise ValueError(f"adaptors must be one of {[*ADAPTORS, None]}, not {self.adaptors!r}")
        if self.rank < 1:
            raise ValueError(f"rank must be at least 1, not {self.rank}")
        if not self.injector and self.heightmap:
            raise ValueError("an adaptation without an injector cannot read a heightmap; use injector=True")

    def injected_spaces(self, space_count: int) -> tuple[int, ...]:
        """Indices of the latent spaces that are injected.

        Args:
            space_count: number of latent spaces of the base (hidden layers + 1).

        Raises:
            ValueError: if `injection` names no such space.
        """
        if not self.injector:
            return ()
        table = {f"z{index}": (index,) for index in range(space_count)} | {"all": tuple(range(space_count))}
        if self.injection not in table:
            raise ValueError(f"injection must be one of {list(table)}, not {self.injection!r}")
        return table[self.injection]


@dataclass(frozen=True)
class CriticShape(JsonValues):
    """What a critic is made of; the defaults are the paper's (fig. 6b).

    Attributes:
        encoder: "own", which learns, or "base": the frozen encoder of the base that is adapted, whose codes are known
            from acting. An own encoder costs as much as the actor's: about half of an update's products.
        hidden_sizes: widths of the fully connected layers; None for those of the policy network.
    """

    encoder: str = OWN
    hidden_sizes: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        if self.encoder not in (OWN, OF_BASE):
            raise ValueError(f"the critic's encoder must be one of {[OWN, OF_BASE]}, not {self.encoder!r}")
        if self.hidden_sizes is not None and (not self.hidden_sizes or min(self.hidden_sizes) < 1):
            raise ValueError(f"the critic's hidden_sizes must be positive widths, not {list(self.hidden_sizes)}")
