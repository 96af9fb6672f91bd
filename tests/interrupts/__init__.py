"""Ctrl-C at many moments of every command: `python -m tests.interrupts --points N`."""
