"""The networks, in plain torch: nothing here knows of Stable-Baselines3 or of environments."""
