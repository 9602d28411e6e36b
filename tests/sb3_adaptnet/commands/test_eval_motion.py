"""`adaptnet eval --bvh` and `--glb`."""

import sys

import numpy as np
import pytest
from evaluation_cases import save_tiny_base

from adapt_envs.motion.importing.bvh import read_bvh
from sb3_adaptnet.commands.main import main

QUICK = ["--seconds", "10", "--threads", "1"]


def test_the_motion_of_a_rollout_is_written(tmp_path, capsys):
    pytest.importorskip("pygltflib", reason="glTF needs optional packages: pip install 'adaptnet-gym[motion]'")
    base, bvh, glb = save_tiny_base(tmp_path), tmp_path / "out.bvh", tmp_path / "out.glb"
    assert main(["eval", str(base), *QUICK, "--bvh", str(bvh), "--glb", str(glb)]) == 0
    printed = capsys.readouterr().out
    assert f"wrote {bvh}" in printed and f"wrote {glb}" in printed
    read = read_bvh(bvh)
    assert len(read.pos) >= 6 and np.ptp(read.pos[:, 0], axis=0).max() > 0.5  # [cm]
    assert glb.read_bytes()[:4] == b"glTF"


@pytest.mark.parametrize(
    "words, complaint",
    [(["--bvh", "out.fbx"], "must be .bvh"), (["--glb", "out.gltf"], "must be .glb"),
     (["--bvh", "no/out.bvh"], "does not exist")],
)  # fmt: skip
def test_files_that_cannot_be_written_are_refused_before_the_measuring(tmp_path, capsys, words, complaint):
    assert main(["eval", str(save_tiny_base(tmp_path)), *QUICK, words[0], str(tmp_path / words[1])]) == 2
    assert complaint in capsys.readouterr().err


def test_the_missing_package_is_named_before_the_measuring(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "pygltflib", None)
    assert main(["eval", str(save_tiny_base(tmp_path)), *QUICK, "--glb", str(tmp_path / "out.glb")]) == 2
    assert "pip install 'adaptnet-gym[motion]'" in capsys.readouterr().err
