"""Steering a policy live: by keys in a window, or by sliders in the browser."""

from sb3_adaptnet.play.browser import Browser
from sb3_adaptnet.play.controls import Controls, View, play
from sb3_adaptnet.play.keyboard import Keyboard

__all__ = ["Browser", "Controls", "Keyboard", "View", "play"]
