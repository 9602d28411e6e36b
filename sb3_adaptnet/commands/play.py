"""`adaptnet play`: steer a policy by hand, in a window or in the browser."""

import argparse
from typing import Any

from adapt_envs.commands.numbers import port_of, positive, seed_of
from adapt_envs.drawing.scene import RenderingError
from adapt_envs.drawing.world_view import Window
from adapt_envs.simulation.worlds import Worlds
from sb3_adaptnet.commands.policy_options import add_options, open_from_options
from sb3_adaptnet.play import Browser, Controls, Keyboard, View, play
from sb3_adaptnet.play.keyboard import HELP

VIEWS = ("auto", "window", "browser")
"""Where a policy can be shown; the first is the default."""


def add_parser(subparsers: Any) -> None:
    """Add the subcommand `play`."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "play", help="steer a policy by hand: alpha, blend, speed and heading, in a window or the browser"
    )
    add_options(parser)
    words = "where to show it; auto (default): a window where there is a display, else the browser"
    parser.add_argument("--view", choices=VIEWS, default="auto", help=words)
    parser.add_argument("--host", default="127.0.0.1", help="address to serve the browser at (default 127.0.0.1)")
    parser.add_argument("--port", type=port_of, default=8080, help="port to serve the browser at (default 8080)")
    parser.add_argument("--seed", type=seed_of, default=0, help="of start states and goals (default 0)")
    parser.add_argument("--steps", type=positive, help="leave after this many control steps; default: when closed")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Play until the window is closed or Ctrl-C."""
    loaded = open_from_options(options, num_worlds=1)
    controls = Controls.of(loaded.policy, loaded.env, loaded.style)
    try:
        view = open_view(options, loaded.env.worlds, controls)
        try:
            play(loaded.policy, loaded.env, view, controls, options.steps, options.seed)
        finally:
            view.close()
    except KeyboardInterrupt:
        print()
    return 0


def open_view(options: argparse.Namespace, worlds: Worlds, controls: Controls) -> View:
    """The view that was asked for; says where it is and how to use it.

    Raises:
        RenderingError: if it cannot be opened here.
    """
    if options.view != "browser":
        try:
            window = Window(worlds, on_key=Keyboard(controls).press)
            print(HELP)
            return window
        except (RenderingError, RuntimeError) as error:  # macOS wants mjpython for a window: a RuntimeError
            if options.view == "window":
                raise RenderingError(str(error)) from error
            print(f"no window: {error}")
    browser = Browser(worlds, controls, options.host, options.port)
    print(f"open {browser.address} in a browser; Ctrl-C ends it", flush=True)
    return browser
