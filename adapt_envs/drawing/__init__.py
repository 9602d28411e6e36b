"""Pictures: scenes, worlds, contact sheets, plots."""

from adapt_envs.drawing import headless as headless  # first: it chooses OpenGL's backend before MuJoCo is imported
