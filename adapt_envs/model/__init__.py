"""The character and its ground as MuJoCo models."""
