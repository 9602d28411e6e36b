"""The command line `adaptnet`."""
