"""`adaptnet motions`: what it prints, writes and returns."""

import argparse
import json
from pathlib import Path

import numpy as np
import pytest
from made_up_motions import bvh_text, json_object, write

from adapt_envs.assets import asset_path
from adapt_envs.commands import motions
from adapt_envs.model.humanoid import joint_names
from adapt_envs.motion.clip import MotionClip, MotionError
from adapt_envs.motion.library import CLIPS
from adapt_envs.motion.quality import THRESHOLDS
from adapt_envs.motion.synthesis.styles import GAITS

FIELDS = {
    "name", "seconds", "slip_median_cm_s", "slip_p90_cm_s", "penetration_cm", "limit_violation_deg", "zmp_in_support",
    "force_min", "force_max", "flight_g_error", "ok",
}  # fmt: skip


def call(*arguments: str) -> int:
    """Exit code of `adaptnet motions ...`."""
    parser = argparse.ArgumentParser()
    motions.add_parser(parser.add_subparsers())
    options = parser.parse_args(["motions", *arguments])
    return options.run(options)


@pytest.fixture
def stand(tmp_path: Path) -> Path:
    """A clip that stands still: it keeps every threshold for quiet motions."""
    qpos = np.zeros((40, 7 + len(joint_names())))
    qpos[:, 2:4] = (0.881416, 1)
    path = tmp_path / "stand.npz"
    MotionClip("stand", qpos, joint_names()).save(path)
    return path


@pytest.fixture
def sunk(stand: Path) -> Path:
    """The same, 5 cm under the ground."""
    clip = MotionClip.load(stand)
    path = stand.with_name("sunk.npz")
    MotionClip("sunk", clip.qpos - np.eye(1, clip.qpos.shape[1], 2) * 0.05, clip.joint_names).save(path)
    return path


def test_import_writes_a_clip_that_check_and_render_take(tmp_path, capsys):
    output = tmp_path / "walk.npz"
    assert call("import", str(write(tmp_path, "walk.bvh", bvh_text())), "-o", str(output)) == 0
    assert "clip of 1.97 s" in capsys.readouterr().out
    clip = MotionClip.load(output)
    assert clip.name == "walk" and clip.origin == "imported from walk.bvh" and len(clip.qpos) == 60
    call("check", "--json", str(output))
    assert json.loads(capsys.readouterr().out)[0]["limit_violation_deg"] == 0
    assert call("render", str(output), "-o", str(tmp_path / "walk.png")) == 0
    assert (tmp_path / "walk.png").read_bytes().startswith(b"\x89PNG")


def test_import_of_a_style(tmp_path, capsys):
    output = tmp_path / "style.npz"
    assert call("import", str(write(tmp_path, "w.json", json_object(frames=90))), "-o", str(output), "--style") == 0
    assert "cycle of 1.20 s" in capsys.readouterr().out
    assert MotionClip.load(output).cyclic


def test_check_measures_files_and_returns_1_if_one_misses(stand, sunk, capsys):
    assert call("check", str(stand)) == 0
    assert call("check", "--json", str(stand), str(sunk)) == 1
    good, bad = json.loads(capsys.readouterr().out.split("ok\n")[-1])
    assert set(good) == FIELDS
    assert good["ok"] and not bad["ok"]
    assert good["penetration_cm"] < 0.01 and bad["penetration_cm"] == pytest.approx(5, abs=0.01)
    assert good["flight_g_error"] is None
    assert good["force_min"] == pytest.approx(1, abs=1e-3)


def test_check_holds_files_to_the_bars_asked_for(stand, capsys):
    assert call("check", "--kind", "hopping", str(stand)) == 1  # a hop without a flight is none
    with pytest.raises(SystemExit):
        call("check", "--kind", "lying", str(stand))
    refusal = capsys.readouterr().err
    assert all(kind in refusal for kind in THRESHOLDS)


def test_check_takes_motion_files_as_they_are(tmp_path, capsys):
    call("check", "--json", str(write(tmp_path, "walk.bvh", bvh_text())))
    assert json.loads(capsys.readouterr().out)[0]["name"] == "walk"


@pytest.mark.parametrize("action", [["check"], ["render", "-o", "x.png"]])
def test_unknown_names_are_refused_with_the_known_ones(action):
    with pytest.raises(MotionError, match="no motion named 'Stroll'.*Stoop"):
        call(*action, "Stroll")


def test_render_refuses_outputs_that_cannot_be(stand, tmp_path):
    with pytest.raises(ValueError, match=r"the extension must be \.png or \.mp4 or \.gif, not \.pdf"):
        call("render", str(stand), "-o", str(tmp_path / "x.pdf"))
    with pytest.raises(ValueError, match="does not exist"):
        call("render", str(stand), "-o", str(tmp_path / "no" / "x.png"))


def test_kinds_of_quality_bars_are_the_tables():
    assert motions.kind_of("walk") == GAITS["walk"].kind == "walk"
    assert motions.kind_of("stroll.bvh") == motions.kind_of("walk.bvh") == "quiet"


def _shipped() -> bool:
    try:
        return all(asset_path(path).exists() for path in CLIPS.values())
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not _shipped(), reason="the clips that ship are not generated yet")
def test_list_names_every_motion_that_ships(capsys):
    assert call("list") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:]] == list(CLIPS)
