"""The subcommands `doctor`, `envs` and `motions`: each module has `add_parser` and returns exit codes."""
