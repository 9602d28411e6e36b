"""How far a world model drifts from the simulation, by its horizon: what a model's card says of it."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.world_model.fitting.fit import open_loop, sample_starts
from sb3_adaptnet.world_model.links import POSITION
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.transitions import Transitions

HORIZONS = (1, 4, 8, 16, 32)
"""Control steps ahead."""
SAMPLES = 2048
"""Windows that the errors are means of."""


@dataclass(frozen=True)
class ErrorTable:
    """Mean errors of link positions [m] without looking at the simulation again.

    Attributes:
        steps: horizons in control steps.
        world: error at each horizon in the world frame.
        heading: error in each one's own heading frame: the pose, wherever the character went.
    """

    steps: tuple[int, ...]
    world: tuple[float, ...]
    heading: tuple[float, ...]

    def to_dict(self) -> dict[str, list[float]]:
        """The table as JSON values, rounded to 0.1 mm."""
        rounded = {name: [round(error, 4) for error in getattr(self, name)] for name in ("world", "heading")}
        return {"steps": list(self.steps), **rounded}

    def at(self, steps: tuple[int, ...]) -> "ErrorTable":
        """The rows of some of the horizons."""
        rows = [self.steps.index(step) for step in steps]
        return ErrorTable(steps, tuple(self.world[row] for row in rows), tuple(self.heading[row] for row in rows))

    def __str__(self) -> str:
        """The table for people."""
        rows = [("steps ahead", [f"{step}" for step in self.steps])]
        rows += [(f"{name} frame [m]", [f"{e:.3f}" for e in getattr(self, name)]) for name in ("world", "heading")]
        return "\n".join(f"{name:<20}" + "".join(f"{cell:>8}" for cell in cells) for name, cells in rows)


@torch.no_grad()
def error_table(
    model: WorldModel,
    held_out: Transitions,
    seed: int = 0,
    samples: int = SAMPLES,
    horizons: tuple[int, ...] = HORIZONS,
) -> ErrorTable:
    """Errors of a model on transitions that it was not fitted to.

    Args:
        model: the model.
        held_out: transitions.
        seed: of the windows' starts.
        samples: windows; all that there are where they are not more.
        horizons: rising numbers of control steps.

    Raises:
        ValueError: if no episode is as long as the last horizon.
    """
    starts: NDArray[np.integer] = held_out.starts(horizons[-1])
    if not 0 < len(starts) <= samples:  # sampling refuses none at all
        starts = sample_starts(held_out, horizons[-1], samples, np.random.default_rng(seed))
    world, heading = [], []
    for step, (_, links) in enumerate(open_loop(model, held_out, starts, horizons[-1]), start=1):
        if step in horizons:
            true = model.kinematics(held_out.states(starts, step).to(links.device))
            world.append(_distance(links, true))
            heading.append(_distance(model.view(links).links, model.view(true).links))
    return ErrorTable(horizons, tuple(world), tuple(heading))


def coasting(model: WorldModel) -> WorldModel:
    """A model of the same character to whom nothing ever happens: velocities stay as they are."""
    still = WorldModel(model.character, Sizes(1, 1))
    torch.nn.init.zeros_(still.dynamics.last.weight)
    return still


def _distance(a: torch.Tensor, b: torch.Tensor) -> float:
    """Mean distance [m] of the links of two link arrays."""
    return float((a[POSITION] - b[POSITION]).norm(dim=0).mean())
