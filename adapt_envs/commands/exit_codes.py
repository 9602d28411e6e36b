"""Exit codes of the command line beside 0."""

BAD_INPUT = 2
"""Something asked for cannot be; one sentence says what."""
INTERRUPTED, PIPE_CLOSED = 130, 141
"""What shells have for Ctrl-C, and for a reader of the output that is gone."""
