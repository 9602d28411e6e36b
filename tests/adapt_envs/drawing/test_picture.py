"""Text, tiles, colours and files of pictures."""

import cv2
import numpy as np
import pytest

from adapt_envs.drawing import palette
from adapt_envs.drawing.picture import blank, text_band, text_width, tiled, write_png, write_text


def inked(picture, paper=palette.PAPER):
    """First and last row and column of what differs from the paper."""
    rows, columns = np.nonzero((picture != paper).any(axis=2))
    return rows.min(), rows.max(), columns.min(), columns.max()


@pytest.mark.parametrize("size", [12, 15, 17, 30])
def test_text_stands_on_its_baseline_and_is_as_wide_as_was_said(size):
    picture = blank(600, 80)
    write_text(picture, "Humanoid", 20, 50, size)
    top, bottom, left, right = inked(picture)
    assert abs(bottom - 50) <= 2
    assert bottom - top == pytest.approx(0.7 * size, abs=4)
    assert abs(left - 20) <= 3
    assert right - left == pytest.approx(text_width("Humanoid", size), abs=8)


def test_text_has_the_colour_in_the_order_red_green_blue():
    picture = blank(200, 60)
    write_text(picture, "III", 20, 50, 45, palette.RED)
    darkest = picture.reshape(-1, 3)[np.abs(picture.astype(int) - palette.PAPER).sum(axis=2).argmax()]
    assert np.abs(darkest.astype(int) - palette.RED).max() < 40
    assert darkest[0] > darkest[2] + 60


def test_a_line_stands_in_the_middle_of_its_band():
    top, bottom, left, right = inked(text_band("HNH", 300, 40, 20))
    assert abs((top + bottom) / 2 - 20) <= 2 and abs((left + right) / 2 - 150) <= 3


def test_a_line_that_is_too_long_is_written_smaller():
    _, _, left, right = inked(text_band("a rather long line of text " * 4, 300, 40, 20))
    assert left >= 2 and right < 298
    assert right - left > 200  # OpenCV 5 rounds sizes to whole pixels


def test_tiles_lie_in_their_cells_and_short_rows_end_in_paper():
    tiles = [np.full((5, 7, 3), value, np.uint8) for value in range(3)]
    sheet = tiled([tiles[:2], tiles[2:]], columns=2, gap=3)
    assert sheet.shape == (2 * 8 + 3, 2 * 10 + 3, 3)
    for value, (row, column) in enumerate([(0, 0), (0, 1), (1, 0)]):
        assert (sheet[3 + 8 * row :][:5, 3 + 10 * column :][:, :7] == value).all()
    assert (sheet[8 + 3 :, 10 + 3 :] == palette.PAPER).all() and (sheet[:3] == palette.PAPER).all()
    assert tiled([tiles], 3).shape == (5, 21, 3)


def test_a_png_keeps_every_pixel_and_their_order(tmp_path):
    picture = np.random.default_rng(0).integers(256, size=(31, 17, 3), dtype=np.uint8)
    write_png(picture, tmp_path / "gänge.png")
    read = cv2.imdecode(np.fromfile(tmp_path / "gänge.png", np.uint8), cv2.IMREAD_COLOR)
    np.testing.assert_array_equal(read[..., ::-1], picture)
    with pytest.raises(OSError):
        write_png(picture, tmp_path / "nowhere" / "x.png")


def test_colours_as_pages_write_them():
    assert palette.css(palette.BLUE) == "#42709b"
    assert palette.css((0, 1, 255)) == "#0001ff"
    assert len(set(palette.SERIES)) == len(palette.SERIES)
