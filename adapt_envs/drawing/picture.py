"""Pictures as arrays: text on them, tiles of them in rows, and PNG files."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from adapt_envs.drawing.palette import INK, PAPER, Colour
from adapt_envs.motion.whole_file import write_whole

Image = NDArray[np.uint8]
"""A picture: (height, width, 3), red, green and blue."""

_FONT = cv2.FONT_HERSHEY_SIMPLEX
"""A sans serif in OpenCV 5; strokes in OpenCV 4, which are wider."""
_FONT_SIZE = 30.0
"""Size [pixels] of the font at scale 1."""
_CAPITALS = 0.7
"""Height of capitals as a share of the size."""
_MARGIN = 4
"""Least space [pixels] on either side of a line of text."""
_SMALLEST_PNG = (cv2.IMWRITE_PNG_COMPRESSION, 9, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_FILTERED)


def blank(width: int, height: int, colour: Colour = PAPER) -> Image:
    """A picture of one colour."""
    return np.full((height, width, 3), colour, np.uint8)


def text_width(text: str, size: float) -> int:
    """Width [pixels] of a line of text."""
    return cv2.getTextSize(text, _FONT, size / _FONT_SIZE, 1)[0][0]


def write_text(picture: Image, text: str, left: int, baseline: int, size: float, colour: Colour = INK) -> None:
    """Write a line of text into a picture.

    Args:
        picture: changed in place.
        text: what to write.
        left: column at which it begins.
        baseline: row on which the letters stand.
        size: of the font [pixels].
        colour: of the letters.
    """
    cv2.putText(picture, text, (left, baseline), _FONT, size / _FONT_SIZE, colour, 1, cv2.LINE_AA)


def text_band(text: str, width: int, height: int, size: float, colour: Colour = INK) -> Image:
    """A band with a line of text in its middle; the font is smaller than `size` [pixels] where the line is too long."""
    band = blank(width, height)
    size *= min(1.0, (width - 2 * _MARGIN) / max(text_width(text, size), 1))
    write_text(band, text, (width - text_width(text, size)) // 2, round((height + _CAPITALS * size) / 2), size, colour)
    return band


def tiled(rows: Sequence[Sequence[Image]], columns: int, gap: int = 0) -> Image:
    """Put tiles of one size into rows, with `gap` pixels of paper between and around them; short rows end in paper."""
    height, width = rows[0][0].shape[:2]
    sheet = blank(columns * (width + gap) + gap, len(rows) * (height + gap) + gap)
    for i, row in enumerate(rows):
        for j, tile in enumerate(row):
            top, left = gap + i * (height + gap), gap + j * (width + gap)
            sheet[top : top + height, left : left + width] = tile
    return sheet


def write_png(picture: Image, path: str | Path) -> None:
    """Write a picture as a PNG, compressed as far as it goes, whole or not at all.

    Raises:
        OSError: if the file cannot be written.
    """
    _, encoded = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), _SMALLEST_PNG)
    write_whole(Path(path), encoded.tobytes())
