"""The playground, a page in which the walk is steered, pushed and blended: how it is served."""

import shlex
from pathlib import Path

BUILT = Path(__file__).resolve().parents[2] / "web" / "dist"
"""Folder that `make web` writes in a checkout; an installed package has none."""
_PORT = 8000
ADDRESS = f"http://127.0.0.1:{_PORT}/"
"""Where the page is once it is served; browsers run it from a web server only, not from a file."""


def serving_command(built: Path = BUILT) -> str | None:
    """The command that serves the playground at `ADDRESS`, or None if it was not built."""
    if not (built / "index.html").is_file():
        return None
    return f"python -m http.server --bind 127.0.0.1 -d {shlex.quote(str(built))} {_PORT}"
