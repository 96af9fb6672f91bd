"""Tables, bars and coloured text in the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import IO

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from circumspect.cli.visible_controls import terminal_stream, visible


class OutputConsole(Console):
    """Rich's console, with control characters in texts made visible.

    By itself it ends the process with 1 when its reader goes away.
    """

    @property
    def file(self) -> IO[str]:
        """The stream without `VisibleStream`: rich itself commands the terminal."""
        return terminal_stream(super().file)

    @file.setter
    def file(self, new_file: IO[str]) -> None:
        self._file = new_file

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Render with control characters made visible."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment(visible(segment.text), segment.style)

    def on_broken_pipe(self) -> None:
        """Leave it to `main`, for which `| head` is no fault.

        Raises:
            BrokenPipeError: Always.
        """
        raise BrokenPipeError
