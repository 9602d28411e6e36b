"""``adaptnet bench train``: samples per second of whole training iterations."""
from typing import Any
def add_parser(subparsers: Any) -> None:
    """Add."""
