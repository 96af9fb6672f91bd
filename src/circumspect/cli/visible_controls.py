"""Control characters in what a command prints are made visible: text of files reaches it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import IO, Any, cast

from circumspect.errors import printable

KEPT = "\n\t"
"""These lay text out."""


def visible(text: str) -> str:
    """The text with its control characters as escapes; line ends and tabs stay."""
    if text.isprintable():
        return text
    return "".join(sign if sign in KEPT else printable(sign) for sign in text)


class VisibleStream:
    """A text stream that makes control characters visible; all else is the stream's own."""

    def __init__(self, stream: IO[str]) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write the text with its control characters as escapes."""
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
    """Let standard output and standard error make control characters visible."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = map(cast("Callable[[IO[str]], Any]", VisibleStream), before)
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def terminal_stream(stream: IO[str]) -> IO[str]:
    """The stream itself, for whoever writes a terminal's commands and makes all else visible."""
    return stream.stream if isinstance(stream, VisibleStream) else stream
