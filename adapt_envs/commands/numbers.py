"""Numbers on the command line: one sentence for each that cannot be."""

import argparse
import math

_TINY = math.ulp(0.0)
"""The smallest positive number."""


def positive(text: str) -> int:
    """Parse a positive whole number, also written 2e6."""
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not value.is_integer() or value < 1:  # infinity is no integer
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive whole number")
    return int(value)


def seed_of(text: str) -> int:
    """Parse a seed, as numpy takes it."""
    if not (text.isascii() and text.isdigit() and int(text) < 2**32):
        raise argparse.ArgumentTypeError(f"{text!r} is not a seed, a number from 0 to {2**32 - 1}")
    return int(text)


def port_of(text: str) -> int:
    """Parse a port's number; 0 stands for any free one."""
    if not (text.isascii() and text.isdigit() and int(text) <= 65535):
        raise argparse.ArgumentTypeError(f"{text!r} is not a port, a number from 0 to 65535")
    return int(text)


def seconds_of(text: str) -> float:
    """Parse a positive number of seconds."""
    return _at_least(_TINY, text, "a positive number of seconds")


def minutes_of(text: str) -> float:
    """Parse a number of minutes, at least 0."""
    return _at_least(0.0, text, "a number of minutes, at least 0")


def speed_of(text: str) -> float:
    """Parse a positive number of metres per second."""
    return _at_least(_TINY, text, "a positive number of metres per second")


def _at_least(least: float, text: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not least <= value < math.inf:
        raise argparse.ArgumentTypeError(f"{text!r} is not {what}")
    return value
