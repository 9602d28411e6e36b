"""The command line `adaptnet`: one file for each subcommand, `main` puts them together; nothing to import for users."""

__all__: list[str] = []
