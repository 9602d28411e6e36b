"""What policies and discriminators see: link states, the heading frame, the heightmap."""
