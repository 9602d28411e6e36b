"""Controls on the keys of MuJoCo's window."""

import math

from sb3_adaptnet.play.controls import Controls, weights_between

TURN, FASTER, STRONGER, BLEND = math.radians(15), 0.1, 0.05, 0.1
"""What one press changes: heading [rad], speed [m/s], alpha, place among the styles."""
RIGHT, LEFT, DOWN, UP, PAGE_UP, PAGE_DOWN = 262, 263, 264, 265, 266, 267
ENTER, BACKSPACE, MINUS, EQUALS = 257, 259, 45, 61
"""GLFW's codes of the keys."""
HELP = (
    "keys: left/right turn, up/down speed, -/= alpha, page up/down blend, enter random goals or back, backspace restart"
)
"""What is printed when the window opens."""


class Keyboard:
    """Turns key presses into controls."""

    def __init__(self, controls: Controls) -> None:
        """Act on `controls`; the blend's place is where its heaviest style is."""
        self.controls = controls
        weights = list(controls.weights.values())
        self._place = float(weights.index(max(weights))) if weights else 0.0

    def press(self, key: int) -> None:
        """Take a key's GLFW code; keys that mean nothing are left alone."""
        controls = self.controls
        if key in (LEFT, RIGHT):
            controls.heading = math.remainder(controls.heading + (TURN if key == LEFT else -TURN), math.tau)
        elif key in (UP, DOWN):
            controls.speed = max(FASTER, round(controls.speed + (FASTER if key == UP else -FASTER), 3))
        elif key in (MINUS, EQUALS) and controls.alpha is not None:
            controls.alpha = max(0.0, round(controls.alpha + (STRONGER if key == EQUALS else -STRONGER), 3))
        elif key in (PAGE_UP, PAGE_DOWN) and len(controls.weights) > 1:
            step = BLEND if key == PAGE_UP else -BLEND
            self._place = min(max(self._place + step, 0.0), len(controls.weights) - 1.0)
            controls.weights = weights_between(controls.weights, self._place)
        elif key == ENTER:
            controls.random_goals = not controls.random_goals
        elif key == BACKSPACE:
            controls.restart = True
