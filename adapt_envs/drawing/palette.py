"""The colours of everything that is drawn: pictures, plots, pages, and what is painted into a scene."""

Colour = tuple[int, int, int]
"""Red, green and blue, each 0 to 255."""

INK: Colour = (32, 38, 48)
"""Text."""
SOFT: Colour = (104, 112, 124)
"""Text that steps back: captions, notes."""
PAPER: Colour = (250, 250, 248)
"""The background."""
SHADE: Colour = (239, 239, 234)
"""The background of what stands out from it, such as lines of code."""
RULE: Colour = (220, 220, 214)
"""Thin lines that divide."""
RULE_STRONG: Colour = (138, 147, 160)
"""The line below a table's head."""

BLUE: Colour = (66, 112, 155)
"""Curves; the character's left side has nearly this colour."""
RED: Colour = (212, 92, 69)
"""What is marked; the character's right side has nearly this colour."""
GREY: Colour = (154, 163, 173)
"""The second curve of a plot."""
SERIES: tuple[Colour, ...] = (
    BLUE, RED, (74, 145, 96), (214, 158, 60), (124, 98, 160), (70, 160, 172), (190, 110, 150), (110, 100, 90),
)  # fmt: skip
"""Curves that stand beside each other, in this order; the ninth begins again."""

GOAL = (0.16, 0.62, 0.35, 0.9)
"""A goal in a scene: red, green, blue and opacity as MuJoCo takes them, 0 to 1."""
PUSH = (0.90, 0.12, 0.10, 1.0)
"""A push in a scene, likewise."""


def css(colour: Colour) -> str:
    """The colour as HTML and Matplotlib write it, such as `#42709b`."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
