"""The Stable-Baselines3 policies: a base from nothing, AdaptNet, and the baselines of the paper."""
