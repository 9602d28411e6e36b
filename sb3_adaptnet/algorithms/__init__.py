"""Learners beside PPO, as Stable-Baselines3 algorithms: SVG, through a learned world model."""

from sb3_adaptnet.algorithms.svg import SVG

__all__ = ["SVG"]
