"""Processes that end with what began them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any


@contextmanager
def worker_pool(
    workers: int, initializer: Callable[..., None] | None = None, *arguments: Any
) -> Iterator[ProcessPoolExecutor]:
    """Processes to submit work to; Ctrl-C and any other error end them with all that waits.

    They are spawned: a fork would share the locks of threads that it does not have.

    Args:
        workers: How many.
        initializer: Called first in each; a function of a module.
        arguments: Its arguments.
    """
    context = _Context()
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(workers, context, _begin, (initializer, arguments)) as pool:
        try:
            yield pool
        except BaseException:
            # Else all that waits in the pool would still be done.
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
            raise


class _Worker(SpawnProcess):
    """A process that is started with Ctrl-C blocked, so that it prints no traceback of its own."""

    def start(self) -> None:
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    Process = _Worker


def _begin(initializer: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    _follow_parent()
    if initializer is not None:
        initializer(*arguments)


def _follow_parent() -> None:
    """A worker whose parent was killed would otherwise go on with its job.

    Ctrl-C is the parent's to obey: a worker that took it for a fault of its job would begin the
    next one.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
