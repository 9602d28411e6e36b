"""Steering a policy live: by keys in a window, or by sliders in the browser."""
