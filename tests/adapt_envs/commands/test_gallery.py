"""The contact sheet and the list of environments."""

import argparse

import cv2
import numpy as np
import pytest

from adapt_envs import SUITE, env_id
from adapt_envs.commands import envs
from adapt_envs.commands.gallery import COLUMNS, gallery, snapshot


@pytest.fixture
def command():
    """Runs `adaptnet envs ...`."""
    parser = argparse.ArgumentParser()
    envs.add_parser(parser.add_subparsers())

    def run(*words):
        arguments = parser.parse_args(["envs", *map(str, words)])
        return arguments.run(arguments)

    return run


def test_the_list_names_every_environment(command, capsys):
    assert command("list") == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == [env_id(name) for name in SUITE]
    assert all(len(line.split()) > 3 for line in lines)


def test_a_sheet_is_written(command, tmp_path):
    assert command("sheet", "-o", tmp_path / "sheet.png", "IceWalk", "TerrainHills") == 0
    picture = cv2.imread(str(tmp_path / "sheet.png"))[..., ::-1].astype(int)
    ice, hills = picture[:260, :300], picture[:260, 310:600]
    assert (ice[200:, :, 2] - ice[200:, :, 0]).mean() > 40  # ice is blue
    assert (hills[200:, :, 0] - hills[200:, :, 2]).mean() > (ice[200:, :, 0] - ice[200:, :, 2]).mean() + 30


def test_unknown_names_are_named_before_anything_is_drawn(command, tmp_path):
    with pytest.raises(ValueError, match="'Moon'.*LongShins"):
        command("sheet", "-o", tmp_path / "sheet.png", "Walk", "Moon")
    assert not list(tmp_path.iterdir())


def test_a_file_that_cannot_be_is_refused_before_anything_is_drawn(command, tmp_path, monkeypatch):
    monkeypatch.setattr("adapt_envs.commands.envs.snapshot", None)
    with pytest.raises(ValueError, match="the extension must be .png, not .jpg"):
        command("sheet", "-o", tmp_path / "sheet.jpg", "Walk")
    with pytest.raises(ValueError, match="does not exist"):
        command("sheet", "-o", tmp_path / "no" / "sheet.png", "Walk")


def test_tiles_fill_rows():
    tiles = [np.full((40, 60, 3), i, np.uint8) for i in range(COLUMNS + 1)]
    sheet = gallery(list(SUITE)[: COLUMNS + 1], tiles)
    assert sheet.shape[1] == COLUMNS * 64 + 4
    assert (sheet[4:44, 4:64] == 0).all()
    assert (sheet[40 + 28 + 8 :][:40, 4:64] == COLUMNS).all()


@pytest.mark.parametrize("name", ["LockedElbows", "PushWalk", "Obstacles"])
def test_families_show_what_makes_them_special(name):
    """Locked joints, pushes and obstacles have colours that the plain walk has not."""
    plain, special = (snapshot(row, (160, 144)).astype(int) for row in ("Walk", name))

    def warm(picture):
        return ((picture[..., 0] - picture[..., 2] > 60) & (picture[..., 0] - picture[..., 1] > 30)).sum()

    assert warm(special) > warm(plain) + 20
