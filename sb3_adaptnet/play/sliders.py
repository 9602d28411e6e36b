"""Controls as sliders in the browser."""

import math
from typing import Any

from sb3_adaptnet.play.controls import Controls

SLOWEST, FASTEST, STRONGEST = 0.1, 3.5, 1.5
"""Ends of the sliders for the speed [m/s] and for alpha, unless they are beyond these at first."""


def add_sliders(gui: Any, controls: Controls) -> dict[str, Any]:
    """Add sliders for speed, heading, alpha and blend that write into `controls`.

    Args:
        gui: a viser `GuiApi`.
        controls: what they show and change.

    Returns:
        Their handles by name.
    """
    ends = _around(controls.speed, SLOWEST, FASTEST)
    made = {
        "speed": gui.add_slider("speed [m/s]", **ends, step=0.05, initial_value=controls.speed),
        "heading": gui.add_slider("heading [deg]", min=-180, max=180, step=5, initial_value=0),
        "random goals": gui.add_checkbox("random goals", initial_value=controls.random_goals),
        "restart": gui.add_button("restart"),
    }
    if controls.alpha is not None:
        ends = _around(controls.alpha, 0.0, STRONGEST)
        made["alpha"] = gui.add_slider("alpha", **ends, step=0.05, initial_value=controls.alpha)
    if len(controls.weights) > 1:
        for name, weight in controls.weights.items():
            label = f"blend {controls.labels.get(name, name)}"
            ends = _around(weight, 0.0, 1.0)
            made[f"blend {name}"] = gui.add_slider(label, **ends, step=0.05, initial_value=weight)
    for name, handle in made.items():
        register = handle.on_click if name == "restart" else handle.on_update
        register(lambda event, name=name: take(controls, name, getattr(event.target, "value", True)))
    return made


def _around(value: float, least: float, most: float) -> dict[str, float]:
    """A slider's usual ends, farther apart for a value beyond them: what is shown is what acts."""
    return {"min": min(least, value), "max": max(most, value)}


def take(controls: Controls, name: str, value: Any) -> None:
    """Write the value of the slider `name` into the controls."""
    if name == "heading":
        controls.heading = math.radians(value)
    elif name == "random goals":
        controls.random_goals = bool(value)
    elif name == "restart":
        controls.restart = True
    elif name.startswith("blend "):
        controls.weights = {**controls.weights, name.removeprefix("blend "): float(value)}
    else:
        setattr(controls, name, float(value))
