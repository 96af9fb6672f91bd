"""The command line: commands in `commands`, their shared parts in this package."""
