"""Actors made from a frozen or copied base: AdaptNet and the paper's alternatives."""
