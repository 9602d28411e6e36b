"""Goal, termination and push rules as pure functions over arrays."""
