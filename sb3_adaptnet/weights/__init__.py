"""Weights on disk: safetensors files with cards, and those that ship."""
