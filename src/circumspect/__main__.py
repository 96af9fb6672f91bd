"""`python -m circumspect`: the command line, of the interpreter of your choice."""

from __future__ import annotations

import sys

from circumspect.cli.entry import entry

if __name__ == "__main__":
    sys.exit(entry())
