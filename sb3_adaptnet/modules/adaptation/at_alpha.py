"""An adaptation at another strength for a while."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol


class Scaled(Protocol):
    """What has an alpha."""

    alpha: float


@contextmanager
def at_alpha(scaled: Scaled, alpha: float) -> Iterator[None]:
    """Let it act at another alpha meanwhile."""
    before = scaled.alpha
    scaled.alpha = alpha
    try:
        yield
    finally:
        scaled.alpha = before
