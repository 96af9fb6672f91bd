"""Console, lines and tables in the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import IO, TYPE_CHECKING

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from circumspect.cli.visible_controls import terminal_stream, visible

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text


class OutputConsole(Console):
    """Rich's console with visible control characters.

    Rich's own console exits with code 1 when its reader is closed; this one raises an error.
    """

    @property
    def file(self) -> IO[str]:
        """The stream without `VisibleStream`, because rich writes control sequences."""
        return terminal_stream(super().file)

    @file.setter
    def file(self, new_file: IO[str]) -> None:
        self._file = new_file

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Render with visible control characters."""
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment(visible(segment.text), segment.style)

    def on_broken_pipe(self) -> None:
        """Raise the error; `main` handles a closed pipe, such as `| head`, without a message.

        Raises:
            BrokenPipeError: Always.
        """
        raise BrokenPipeError


def show(*parts: str | Table) -> None:
    """Print lines and tables on standard output; only tables are fitted to the terminal."""
    console = OutputConsole(highlight=False)
    for part in parts:
        console.print(part, markup=False, soft_wrap=isinstance(part, str))


def new_table(names: Sequence[str | Text], figures: Sequence[str | Text] = ()) -> Table:
    """An empty table in the common style of all commands.

    Args:
        names: Headings of left-aligned columns, for words.
        figures: Headings of right-aligned columns, for numbers.
    """
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in names:
        table.add_column(_heading(name))
    for name in figures:
        table.add_column(_heading(name), justify="right")
    return table


def _heading(name: str | Text) -> Text:
    """A copy without markup; rich sets the alignment of the column on it."""
    from rich.text import Text

    return Text(name) if isinstance(name, str) else Text(name.plain)
