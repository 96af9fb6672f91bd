"""The process of the command line: Ctrl-C at any moment ends it with one line, no traceback."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
from types import FrameType, TracebackType
from typing import Any

_shown = sys.excepthook


def _excepthook(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """Python's own, but silent about Ctrl-C: of the moments before `entry` has its handler."""
    if not issubclass(kind, KeyboardInterrupt):
        _shown(kind, error, trace)


# This module is imported by the process of the command line alone.
sys.excepthook = _excepthook

INTERRUPTED = 128 + signal.SIGINT
"""As a shell reports a program that Ctrl-C ended."""


class _CtrlC:
    """The handler of SIGINT while a command runs.

    Attributes:
        came: Whether Ctrl-C was pressed.
    """

    def __init__(self) -> None:
        self.came = False

    def __call__(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002
        self.came = True
        raise KeyboardInterrupt

    def unraisable(self, found: sys.UnraisableHookArgs) -> None:
        """Where Python can raise nothing (a finalizer, a callback of C), it is raised later."""
        if found.exc_type is not None and issubclass(found.exc_type, KeyboardInterrupt):
            later = threading.Timer(0.01, _thread.interrupt_main)
            later.daemon = True
            later.start()
        else:
            sys.__unraisablehook__(found)


def entry() -> int:
    """Run the command that the process was started with.

    Returns:
        Exit code, see `main`.
    """
    ctrl_c = _CtrlC()
    # A job in the background (`&` of a script) is started with SIGINT ignored, and stays so.
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if ours:
        signal.signal(signal.SIGINT, ctrl_c)
        sys.unraisablehook = ctrl_c.unraisable
    try:
        code = _run()
    except BaseException as error:
        # Compiled packages turn it into errors of their own while they load.
        if not ctrl_c.came or isinstance(error, SystemExit):
            raise
        code = _end_interrupted()
    finally:
        if ours:
            # What is left is Python's own end: a further Ctrl-C ends it at once.
            signal.signal(signal.SIGINT, signal.SIG_DFL)
    return code


def _run() -> Any:
    from circumspect.cli.main import main

    return main()


def _end_interrupted() -> int:
    os.write(2, b"circumspect: interrupted; the same command starts or goes on again\n")
    return INTERRUPTED
