"""Tables and coloured text on standard output."""

from __future__ import annotations

from rich.console import Console


class OutputConsole(Console):
    """Rich's console, which by itself ends the process with 1 when its reader goes away."""

    def on_broken_pipe(self) -> None:
        """Leave it to `main`, for which `| head` is no fault.

        Raises:
            BrokenPipeError: Always.
        """
        raise BrokenPipeError
