"""The command line: one file a subcommand; heavy imports happen after parsing."""
