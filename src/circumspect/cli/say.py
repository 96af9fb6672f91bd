"""Messages of a command on standard error, separate from its results."""

from __future__ import annotations

import sys

from circumspect.errors import printable


def say(text: str) -> None:
    """Write a line on standard error."""
    print(f"circumspect: {printable(text)}", file=sys.stderr, flush=True)  # noqa: T201
