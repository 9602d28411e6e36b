"""What a step of a character costs, as differentiable functions of states: one file for each kind."""
