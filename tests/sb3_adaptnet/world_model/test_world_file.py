"""A file holds the model, its character and what was measured of it, and nothing else is taken for one."""

import json

import pytest
import torch
from world_cases import CHARACTER, recorded

from sb3_adaptnet.weights.weight_file import CheckpointError, write_weights
from sb3_adaptnet.world_model.fitting.error_table import error_table
from sb3_adaptnet.world_model.fitting.fit import loss_of
from sb3_adaptnet.world_model.model import Sizes, WorldModel
from sb3_adaptnet.world_model.world_file import read_world, save_world


def test_a_world_file_opens_as_it_was(tmp_path):
    data = recorded(steps=6, worlds=8)
    model = WorldModel(CHARACTER, Sizes(32, 2))
    table = error_table(model, data, samples=10, horizons=(1, 4))
    file = save_world(model, tmp_path / "walk", errors=table.to_dict(), environment="AdaptNet/Humanoid-Walk-v0")
    assert file.name == "walk.world.safetensors"
    read = read_world(file)
    assert read.model.character == CHARACTER
    assert read.card["errors"] == table.to_dict()
    starts = data.starts(4)
    for name, weights in model.state_dict().items():
        found, furthest = read.model.state_dict()[name], float(weights.abs().max()) / 250 + 1e-7
        torch.testing.assert_close(found, weights, rtol=0, atol=furthest, msg=name)
    torch.testing.assert_close(loss_of(read.model, data, starts, 4), loss_of(model, data, starts, 4), rtol=1e-2, atol=0)
    assert json.loads(file.with_suffix(".json").read_text())["kind"] == "world"


def test_other_files_are_refused(tmp_path):
    write_weights(tmp_path / "a.safetensors", {"x": torch.zeros(1)}, {"kind": "base"})
    with pytest.raises(CheckpointError, match="holds 'base', not 'world'"):
        read_world(tmp_path / "a.safetensors")
    write_weights(tmp_path / "b.safetensors", {"x": torch.zeros(1)}, {"kind": "world", "architecture": {}})
    with pytest.raises(CheckpointError, match="does not describe a network"):
        read_world(tmp_path / "b.safetensors")
