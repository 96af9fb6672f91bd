"""SIGTERM, as service managers and `kill` send it, ends a command as Ctrl-C does."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

EXIT_CODE = 128 + signal.SIGTERM
"""As a shell tells it of a program that the signal ended."""


class Terminated(KeyboardInterrupt):
    """SIGTERM came: what was gathered so far is saved, whatever drives is stopped."""


@contextmanager
def ends_as_ctrl_c_does() -> Iterator[None]:
    """Raise `Terminated` in the main thread where the signal would end the program at once.

    A handler that somebody else set stays, and so does a signal that is ignored.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGTERM, _raise)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _raise(*_: object) -> NoReturn:
    raise Terminated
