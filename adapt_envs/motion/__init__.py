"""Reference motions: clips, their synthesis and their import."""
