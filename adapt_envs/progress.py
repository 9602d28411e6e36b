"""How long work shows its progress: a function that wraps what is iterated over, as `tqdm` does."""

from collections.abc import Callable, Iterable

Progress = Callable[[Iterable[int]], Iterable[int]]
"""Wraps the steps of a loop and hands them on; `iter` shows nothing."""
