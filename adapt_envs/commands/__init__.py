"""Subcommands of the command line `adaptnet` that need no learner."""
