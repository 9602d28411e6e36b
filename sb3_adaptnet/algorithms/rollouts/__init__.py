"""What happened in the worlds, as it is learned from."""
