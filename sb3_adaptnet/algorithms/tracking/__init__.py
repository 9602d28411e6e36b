"""What a character shall look like, and what it costs not to: reference motions, guides and losses."""
