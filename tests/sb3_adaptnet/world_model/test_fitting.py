"""Windows stay within episodes; fits lower held-out errors; tables and files say what was measured."""

import json

import numpy as np
import pytest
import torch
from world_cases import CHARACTER, recorded

from sb3_adaptnet.weights.weight_file import CheckpointError, write_weights
from sb3_adaptnet.world_model.error_table import error_table
from sb3_adaptnet.world_model.fitting import Stage, draw, fit, loss_of, set_statistics
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.transitions import Transitions
from sb3_adaptnet.world_model.world_file import read_world, save_world


@pytest.fixture(scope="module")
def data():
    return recorded(steps=24, worlds=32)


def fresh(data, seed=0):
    torch.manual_seed(seed)
    model = WorldModel(CHARACTER, Sizes(32, 2))
    set_statistics(model, data, np.random.default_rng(seed))
    return model


def test_windows_stay_within_episodes():
    ended = np.zeros((6, 2), bool)
    ended[2, 0] = True
    numbers = np.arange(14, dtype=np.float32).reshape(7, 2, 1)
    data = Transitions(numbers, numbers, numbers[:6], ended)
    assert {tuple(start) for start in data.starts(3)} == {(3, 0), (0, 1), (1, 1), (2, 1), (3, 1)}
    assert len(data.starts(1)) == 11
    with pytest.raises(ValueError, match="no episode of the data has 7 transitions"):
        draw(data, 7, 1, np.random.default_rng(0))


def test_worlds_are_held_out_whole(data):
    fitted, judged = data.split(4)
    assert (fitted.num_worlds, judged.num_worlds) == (24, 8)
    assert np.array_equal(judged.actions, data.actions[:, ::4])
    with pytest.raises(ValueError, match="every 33th of 32 worlds"):
        data.split(33)


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
    starts = draw(data, 4, 8, np.random.default_rng(0))
    for step in range(4):
        before, after = (data.states(starts, later).map(torch.Tensor.double) for later in (step, step + 1))
        residual = model.residual(before, after, data.actions_at(starts, step).double())
        found = model.step(before, model.view(model.kinematics(before)), data.actions_at(starts, step), residual)
        assert torch.allclose(model.kinematics(found), model.kinematics(after), atol=1e-6)


def test_a_world_file_opens_as_it_was(data, tmp_path):
    model = fresh(data)
    table = error_table(model, data, samples=10, horizons=(1, 4))
    file = save_world(model, tmp_path / "walk", errors=table.to_dict(), environment="AdaptNet/Humanoid-Walk-v0")
    assert file.name == "walk.world.safetensors"
    read = read_world(file)
    assert read.model.character == CHARACTER
    assert read.card["errors"] == table.to_dict()
    starts = draw(data, 4, 10, np.random.default_rng(0))
    assert torch.equal(loss_of(read.model, data, starts, 4), loss_of(model, data, starts, 4))
    assert json.loads(file.with_suffix(".json").read_text())["kind"] == "world"


def test_other_files_are_refused(tmp_path):
    write_weights(tmp_path / "a.safetensors", {"x": torch.zeros(1)}, {"kind": "base"})
    with pytest.raises(CheckpointError, match="holds 'base', not 'world'"):
        read_world(tmp_path / "a.safetensors")
    write_weights(tmp_path / "b.safetensors", {"x": torch.zeros(1)}, {"kind": "world", "architecture": {}})
    with pytest.raises(CheckpointError, match="does not describe a network"):
        read_world(tmp_path / "b.safetensors")


def test_the_table_reads_well(data):
    lines = str(error_table(fresh(data), data, samples=10, horizons=(1, 8))).splitlines()
    assert [line.split("  ")[0] for line in lines] == [
        "steps ahead",
        "world frame [m]",
        "heading frame [m]",
    ]
