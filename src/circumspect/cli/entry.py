"""Entry point of the process: Ctrl-C at any time prints one line and no traceback."""

from __future__ import annotations

import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType, TracebackType
    from typing import Any

_shown = sys.excepthook


def _excepthook(
    kind: type[BaseException], error: BaseException, trace: TracebackType | None
) -> None:
    """Python's hook without a traceback for Ctrl-C before `entry` sets its handler."""
    if not issubclass(kind, KeyboardInterrupt):
        _shown(kind, error, trace)


# Only the process of the command line imports this module. All further imports follow this line,
# because Ctrl-C may be pressed while they load.
sys.excepthook = _excepthook

import _thread  # noqa: E402
import os  # noqa: E402
import signal  # noqa: E402
import threading  # noqa: E402

INTERRUPTED = 128 + signal.SIGINT
"""Exit code of a program ended by Ctrl-C, as in shells."""


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
        """Raise Ctrl-C later if Python can not raise it now (finalizer, callback of C)."""
        if found.exc_type is not None and issubclass(found.exc_type, KeyboardInterrupt):
            later = threading.Timer(0.01, _thread.interrupt_main)
            later.daemon = True
            later.start()
        else:
            sys.__unraisablehook__(found)


def entry() -> int:
    """Run the command of the process.

    Returns:
        The exit code, see `main`.
    """
    ctrl_c = _CtrlC()
    # A background job of a script (`&`) starts with SIGINT ignored; this is kept.
    ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if ours:
        signal.signal(signal.SIGINT, ctrl_c)
        sys.unraisablehook = ctrl_c.unraisable
    try:
        code = _run()
    except BaseException as error:
        # Compiled packages convert Ctrl-C into their own errors while they load.
        if not ctrl_c.came or isinstance(error, SystemExit):
            raise
        code = _end_interrupted()
    finally:
        if ours:
            # During Python's shutdown a further Ctrl-C ends the process at once.
            signal.signal(signal.SIGINT, signal.SIG_DFL)
    return code


def _run() -> Any:
    from circumspect.cli.main import main

    return main()


def _end_interrupted() -> int:
    os.write(2, b"circumspect: interrupted; the same command starts or resumes it\n")
    return INTERRUPTED
