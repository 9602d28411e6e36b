"""Fitting a world model to transitions: of one step, then of several in a row."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray

from sb3_adaptnet.world_model.integration import change_between
from sb3_adaptnet.world_model.links import POSITION, SPIN, VELOCITY
from sb3_adaptnet.world_model.model import WorldModel
from sb3_adaptnet.world_model.pseudo_huber import pseudo_huber
from sb3_adaptnet.world_model.state import State
from sb3_adaptnet.world_model.transitions import Transitions

SCALES = {"position": 0.03, "velocity": 0.4, "spin": 2.0, "angle": 0.05, "rate": 1.0}
"""Errors of links and joints that count alike [m, m/s, rad/s, rad, rad/s]: their sizes some steps ahead."""
WEIGHTS = {"position": 1.0, "velocity": 1.0, "spin": 0.5, "angle": 0.5, "rate": 0.5}
"""How much each counts."""
STATISTICS_SAMPLES = 40_000
"""Transitions that inputs and changes are normalised by."""
GRADIENT_NORM = 1.0
"""Longest gradient of an update."""


@dataclass(frozen=True)
class Stage:
    """A part of a fit.

    Attributes:
        steps: transitions in a row that the model predicts from its own predictions; 1 compares changes.
        updates: gradient steps.
        batch: windows per update.
        first_rate, last_rate: Adam's step size, falling geometrically from one to the other.
    """

    steps: int
    updates: int
    batch: int
    first_rate: float
    last_rate: float


STAGES = (
    Stage(steps=1, updates=1200, batch=2048, first_rate=1e-3, last_rate=4e-4),
    Stage(steps=4, updates=500, batch=512, first_rate=4e-4, last_rate=3e-4),
    Stage(steps=8, updates=400, batch=512, first_rate=3e-4, last_rate=1e-4),
)
"""The fit of a model that ships: one step first, where data count, then several, where errors add up."""


def scaled(stages: Iterable[Stage], effort: float) -> list[Stage]:
    """Stages with `effort` times as many updates, at least one each."""
    return [replace(stage, updates=max(1, round(effort * stage.updates))) for stage in stages]


def set_statistics(model: WorldModel, data: Transitions, rng: np.random.Generator) -> None:
    """Normalise the model's inputs and changes by the data's."""
    inputs, changes = one_step(model, data, sample_starts(data, 1, STATISTICS_SAMPLES, rng))
    model.dynamics.set_statistics(inputs, changes)


def sample_starts(data: Transitions, steps: int, count: int, rng: np.random.Generator) -> NDArray[np.integer]:
    """(count, 2) starts of windows of `steps` transitions, uniformly.

    Raises:
        ValueError: if no episode is as long as that.
    """
    starts = data.starts(steps)
    if not len(starts):
        raise ValueError(f"no episode of the data has {steps} transitions")
    return starts[rng.integers(len(starts), size=count)]


@torch.no_grad()
def one_step(model: WorldModel, data: Transitions, starts: NDArray[np.integer]) -> tuple[torch.Tensor, torch.Tensor]:
    """Inputs (n, I) and true changes (n, O) of the transitions at (n, 2) starts, on the model's device."""
    device = model.middles.device
    before, after = (data.states(starts, later).to(device) for later in (0, 1))
    view = model.view(model.kinematics(before))
    inputs = model.inputs(view, before, data.actions_at(starts).to(device))
    return inputs, change_between(before, after, view)


def one_step_loss(model: WorldModel, inputs: torch.Tensor, changes: torch.Tensor) -> torch.Tensor:
    """Mean error () of the expected changes, in standard deviations of the changes."""
    dynamics = model.dynamics
    return pseudo_huber((dynamics.normalised_change(inputs) - dynamics.normalise(changes)).square(), 1.0).mean()


def open_loop(
    model: WorldModel, data: Transitions, starts: NDArray[np.integer], steps: int
) -> Iterator[tuple[State, torch.Tensor]]:
    """States and link arrays (13, L, n) that the model expects 1 ... `steps` steps after (n, 2) starts."""
    device = model.middles.device
    state = data.states(starts).to(device)
    links = model.kinematics(state)
    for step in range(steps):
        state = model.step(state, model.view(links), data.actions_at(starts, step).to(device))
        links = model.kinematics(state)
        yield state, links


def open_loop_loss(model: WorldModel, data: Transitions, starts: NDArray[np.integer], steps: int) -> torch.Tensor:
    """Mean error () of links and joints over `steps` steps of the model's own predictions, in units of `SCALES`."""
    device = model.middles.device
    total = torch.zeros((), device=device)
    for step, (state, links) in enumerate(open_loop(model, data, starts, steps), start=1):
        with torch.no_grad():
            true = data.states(starts, step).to(device)
            true_links = model.kinematics(true)
        errors = {
            "position": links[POSITION] - true_links[POSITION],
            "velocity": links[VELOCITY] - true_links[VELOCITY],
            "spin": links[SPIN] - true_links[SPIN],
            "angle": state.angles - true.angles,
            "rate": state.rates - true.rates,
        }
        for name, error in errors.items():
            total = total + WEIGHTS[name] * pseudo_huber(error.square(), SCALES[name]).mean()
    return total / steps


def loss_of(model: WorldModel, data: Transitions, starts: NDArray[np.integer], steps: int) -> torch.Tensor:
    """The loss () of windows of `steps` transitions from (n, 2) starts."""
    if steps == 1:
        return one_step_loss(model, *one_step(model, data, starts))
    return open_loop_loss(model, data, starts, steps)


def fit(
    model: WorldModel, data: Transitions, stage: Stage, optimizer: torch.optim.Optimizer, rng: np.random.Generator
) -> Iterator[float]:
    """Fit through one stage.

    Yields:
        The loss of each update.
    """
    for update in range(stage.updates):
        share = update / stage.updates
        for group in optimizer.param_groups:
            group["lr"] = stage.first_rate * (stage.last_rate / stage.first_rate) ** share
        loss = loss_of(model, data, sample_starts(data, stage.steps, stage.batch, rng), stage.steps)
        descend(model, optimizer, loss)
        yield float(loss.detach())


def descend(model: WorldModel, optimizer: torch.optim.Optimizer, loss: torch.Tensor) -> None:
    """One update of the model down a loss."""
    optimizer.zero_grad()
    loss.backward()
    torch.nn.utils.clip_grad_norm_(model.parameters(), GRADIENT_NORM)
    optimizer.step()
