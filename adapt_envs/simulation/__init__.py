"""The worlds: batched physics, start states, one step over arrays."""
