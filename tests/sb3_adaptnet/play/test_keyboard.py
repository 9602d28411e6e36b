"""Keys turn into controls."""

import math

import pytest

from sb3_adaptnet.play import keyboard
from sb3_adaptnet.play.controls import Controls
from sb3_adaptnet.play.keyboard import Keyboard


def test_keys():
    controls = Controls(speed=1.0, alpha=1.0, weights={"a": 0.0, "b": 1.0, "c": 0.0})
    board = Keyboard(controls)
    for key in (keyboard.LEFT, keyboard.LEFT, keyboard.RIGHT, keyboard.UP, keyboard.MINUS, keyboard.PAGE_UP, 9999):
        board.press(key)
    assert controls.heading == pytest.approx(math.radians(15))
    assert controls.speed == pytest.approx(1.1) and controls.alpha == pytest.approx(0.95)
    assert controls.weights == pytest.approx({"a": 0.0, "b": 0.9, "c": 0.1})
    for _ in range(20):
        board.press(keyboard.PAGE_DOWN)
        board.press(keyboard.DOWN)
    assert controls.weights == pytest.approx({"a": 1.0, "b": 0.0, "c": 0.0}) and controls.speed == pytest.approx(0.1)
    board.press(keyboard.ENTER)
    board.press(keyboard.BACKSPACE)
    assert controls.random_goals and controls.restart
