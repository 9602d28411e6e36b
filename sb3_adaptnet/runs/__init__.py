"""Training runs: entries of the zoo, folders, checkpoints, curves."""
