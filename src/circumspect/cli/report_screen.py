"""Markdown reports in the terminal, with text and tables fitted to its width."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rich.console import Console, ConsoleOptions, RenderResult
from rich.markdown import CodeBlock, Heading, Markdown, MarkdownElement, TableElement
from rich.table import Table
from rich.text import Text

from circumspect.cli.console import OutputConsole, new_table

MAX_LINE = 100
"""Maximum width of a line of text [columns]."""


def print_report(markdown: str) -> None:
    """Print a report on standard output, without its pictures.

    Args:
        markdown: The report.
    """
    lines = [line for line in markdown.splitlines() if not line.startswith("![")]
    console = OutputConsole(highlight=False)
    console.print(_Report("\n".join(lines)), width=min(console.width, MAX_LINE))


class _Heading(Heading):
    """A left-aligned heading."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        self.text.justify = "left"
        self.text.stylize("bold")
        yield self.text


class _Command(CodeBlock):
    """A command without padding, for copying."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        yield Text(str(self.text).rstrip(), style="cyan")


class _FittingTable(TableElement):
    """A table; a wide one is split into parts, each with the first column."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        head = [] if self.header is None or self.header.row is None else self.header.row.cells
        rows = [] if self.body is None else [row.cells for row in self.body.rows]
        names = [cell.content for cell in head]
        cells = [[cell.content for cell in row] for row in rows]
        for number, part in enumerate(_parts(console, options, names, cells)):
            if number:
                yield Text()
            yield part


class _Report(Markdown):
    elements: ClassVar[dict[str, type[MarkdownElement]]] = {
        **Markdown.elements,
        "heading_open": _Heading,
        "fence": _Command,
        "table_open": _FittingTable,
    }


def _parts(
    console: Console, options: ConsoleOptions, head: Sequence[Text], rows: Sequence[Sequence[Text]]
) -> list[Table]:
    """The minimum number of tables that fit the width; a column that is too wide is wrapped."""

    def part(first: int, last: int) -> Table:
        columns = [0, *range(first, last)]
        return _table([head[i] for i in columns], [[row[i] for i in columns] for row in rows])

    def fits(table: Table) -> bool:
        wide = options.update(max_width=10_000)
        return console.measure(table, options=wide).maximum <= options.max_width

    parts, first = [], 1
    while first < len(head):
        ends = range(len(head), first, -1)
        last = next((end for end in ends if fits(part(first, end))), first + 1)
        parts.append(part(first, last))
        first = last
    return parts or [_table(head, rows)]


def _table(head: Sequence[Text], rows: Sequence[Sequence[Text]]) -> Table:
    """A table with names on the left and figures on the right."""
    table = new_table(head[:1], head[1:])
    for name, *figures in rows:
        cells = [cell.copy() for cell in figures]
        for cell in cells:
            cell.justify = "right"
        table.add_row(name.copy(), *cells)
    return table
