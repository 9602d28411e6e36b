"""Fits lower held-out errors; the table says by how much."""

import numpy as np
import pytest
import torch
from world_cases import CHARACTER, recorded

from sb3_adaptnet.world_model.fitting.error_table import coasting, error_table
from sb3_adaptnet.world_model.fitting.fit import Stage, fit, sample_starts, set_statistics
from sb3_adaptnet.world_model.integration import CONTROL_DT
from sb3_adaptnet.world_model.model import Sizes, WorldModel


@pytest.fixture(scope="module")
def data():
    return recorded(steps=24, worlds=32)


def fresh(data, seed=0):
    torch.manual_seed(seed)
    model = WorldModel(CHARACTER, Sizes(32, 2))
    set_statistics(model, data, np.random.default_rng(seed))
    return model


@pytest.mark.parametrize("steps", [1, 4])
def test_a_fit_lowers_the_held_out_error(data, steps):
    fitted, judged = data.split(4)
    model = fresh(fitted)
    optimizer = torch.optim.Adam(model.parameters())
    before = error_table(model, judged, samples=100, horizons=(1, 4))
    losses = list(fit(model, fitted, Stage(steps, 60, 64, 3e-3, 1e-3), optimizer, np.random.default_rng(0)))
    after = error_table(model, judged, samples=100, horizons=(1, 4))
    assert np.mean(losses[-10:]) < 0.8 * np.mean(losses[:10])
    assert after.world[1] < before.world[1]
    assert after.heading[1] < before.heading[1]


def test_the_true_change_has_no_loss(data):
    """With a network that knows the answer both losses vanish: prediction and truth take the same path."""
    model = fresh(data).double()
    starts = sample_starts(data, 4, 8, np.random.default_rng(0))
    for step in range(4):
        before, after = (data.states(starts, later).map(torch.Tensor.double) for later in (step, step + 1))
        residual = model.residual(before, after, data.actions_at(starts, step).double())
        found = model.step(before, model.view(model.kinematics(before)), data.actions_at(starts, step), residual)
        assert torch.allclose(model.kinematics(found), model.kinematics(after), atol=1e-6)


def test_the_table_reads_well(data):
    lines = str(error_table(fresh(data), data, samples=10, horizons=(1, 8))).splitlines()
    assert [line.split("  ")[0] for line in lines] == [
        "steps ahead",
        "world frame [m]",
        "heading frame [m]",
    ]


def test_few_transitions_are_all_judged_whatever_the_seed(data):
    model, windows = fresh(data), len(data.starts(8))
    assert error_table(model, data, 0, windows, (8,)) == error_table(model, data, 1, windows + 1, (8,))
    assert error_table(model, data, 0, windows - 1, (8,)) != error_table(model, data, 1, windows - 1, (8,))


def test_a_coasting_model_keeps_the_velocities(data):
    model = coasting(fresh(data))
    starts = sample_starts(data, 1, 8, np.random.default_rng(0))
    before = data.states(starts, 0)
    after = model.step(before, model.view(model.kinematics(before)), data.actions_at(starts, 0))
    assert torch.allclose(after.velocity, before.velocity, atol=1e-6)
    assert torch.allclose(after.rates, before.rates, atol=1e-6)
    assert torch.allclose(after.position, before.position + CONTROL_DT * before.velocity, atol=1e-5)


def test_rows_of_a_table_can_be_chosen(data):
    table = error_table(fresh(data), data, samples=10, horizons=(1, 2, 4, 8))
    assert table.at((2, 8)).world == (table.world[1], table.world[3])
