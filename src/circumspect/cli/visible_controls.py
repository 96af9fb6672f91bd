"""Escapes control characters in printed text, which may come from files."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, Any, cast

from circumspect.errors import printable

KEPT = "\n\t"
"""Control characters that are kept."""


def visible(text: str) -> str:
    """The text with escaped control characters, except line ends and tabs."""
    if text.isprintable():
        return text
    return "".join(sign if sign in KEPT else printable(sign) for sign in text)


class VisibleStream:
    """Wraps a text stream and escapes control characters in written text."""

    def __init__(self, stream: IO[str]) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write the text with escaped control characters."""
        self.stream.write(visible(text))
        return len(text)

    def writelines(self, lines: Any) -> None:
        """Write each line."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def visible_controls() -> Iterator[None]:
    """Escape control characters on standard output and standard error within the block."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = map(cast("Callable[[IO[str]], Any]", VisibleStream), before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def terminal_stream(stream: IO[str]) -> IO[str]:
    """The wrapped stream, for callers that write control sequences and escape other text."""
    return stream.stream if isinstance(stream, VisibleStream) else stream
