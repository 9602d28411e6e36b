"""Motions from elsewhere: BVH and JSON files become clips of the character."""
