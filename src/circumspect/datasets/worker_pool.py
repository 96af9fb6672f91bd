"""Pool of worker processes that end with their parent."""

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
    """Pool of worker processes; Ctrl-C and any other error end them with all pending work.

    Processes are spawned: a forked process would inherit locks of threads that it does not have.

    Args:
        workers: Number of processes.
        initializer: Called first in each process; a function of a module.
        arguments: Arguments of the initializer.
    """
    context = _Context()
    others = set(multiprocessing.active_children())
    with ProcessPoolExecutor(workers, context, _begin, (initializer, arguments)) as pool:
        try:
            yield pool
        except BaseException:
            # Otherwise the pool would finish all pending work.
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()) - others:
                process.terminate()
            raise


class _Worker(SpawnProcess):
    """A process started with Ctrl-C blocked, so that it does not print its own traceback."""

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
    """End this worker if its parent is killed.

    Only the parent handles Ctrl-C: a worker would take it for an error of its job and start the
    next one.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
