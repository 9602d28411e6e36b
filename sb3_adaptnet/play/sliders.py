"""Controls as sliders in the browser."""

import math
from typing import Any

from sb3_adaptnet.play.controls import Controls

SLOWEST, FASTEST, STRONGEST = 0.1, 3.5, 1.5
"""Ends of the sliders for the speed [m/s], unless a clip is slower or faster, and for alpha."""


def add_sliders(gui: Any, controls: Controls) -> dict[str, Any]:
    """Add sliders for speed, heading, alpha and blend that write into `controls`.

    Args:
        gui: a viser `GuiApi`.
        controls: what they show and change.

    Returns:
        Their handles by name.
    """
    made = {
        "speed": gui.add_slider("speed [m/s]", **_around(controls.speed), step=0.05, initial_value=controls.speed),
        "heading": gui.add_slider("heading [deg]", min=-180, max=180, step=5, initial_value=0),
        "random goals": gui.add_checkbox("random goals", initial_value=controls.random_goals),
        "restart": gui.add_button("restart"),
    }
    if controls.alpha is not None:
        alpha = min(max(controls.alpha, 0.0), STRONGEST)
        made["alpha"] = gui.add_slider("alpha", min=0.0, max=STRONGEST, step=0.05, initial_value=alpha)
    if len(controls.weights) > 1:
        for name, weight in controls.weights.items():
            value = min(max(weight, 0.0), 1.0)
            label = f"blend {controls.labels.get(name, name)}"
            made[f"blend {name}"] = gui.add_slider(label, min=0.0, max=1.0, step=0.05, initial_value=value)
    for name, handle in made.items():
        register = handle.on_click if name == "restart" else handle.on_update
        register(lambda event, name=name: take(controls, name, getattr(event.target, "value", True)))
    return made


def _around(speed: float) -> dict[str, float]:
    """The ends of the speed's slider."""
    return {"min": min(SLOWEST, speed), "max": max(FASTEST, speed)}


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
