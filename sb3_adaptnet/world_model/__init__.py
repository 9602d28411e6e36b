"""A learned, differentiable world: the character's kinematics and dynamics, fitted to its simulation."""
