"""Learners beside PPO, as Stable-Baselines3 algorithms."""
