"""Many long jobs over processes; what is done already is not done again."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any, Protocol, TypeVar

Record = dict[str, Any]
EACH = 8
"""Jobs after which a process is renewed."""


class Job(Protocol):
    """Something to do, told from others by its key."""

    @property
    def key(self) -> str: ...


SomeJob = TypeVar("SomeJob", bound=Job)


def records(path: Path) -> list[Record]:
    """What was written down so far; a line that an interruption cut is left out."""
    if not path.exists():
        return []
    found = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            found.append(json.loads(line))
        except ValueError:
            print(f"{path}: a broken line is left out", file=sys.stderr)
    return found


def run_all(
    jobs: Sequence[SomeJob], work: Callable[[SomeJob], Record], path: Path, workers: int
) -> list[Record]:
    """Do what is not done yet, appending one JSON line for each job as it ends.

    A job that fails for an unknown reason is told and left for the next time.

    Returns:
        The records of all given jobs that are done.
    """
    done = {record["key"] for record in records(path)}
    open_jobs = [job for job in jobs if job.key not in done]
    print(f"{len(jobs) - len(open_jobs)} of {len(jobs)} are done already", file=sys.stderr)
    path.parent.mkdir(parents=True, exist_ok=True)
    # One thread a process: more would only wait for each other.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    start = time.monotonic()
    number = 0
    for first in range(0, len(open_jobs), EACH * workers):
        for job, outcome in _outcomes(open_jobs[first : first + EACH * workers], work, workers):
            number += 1
            if isinstance(outcome, BaseException):
                print(f"{job.key} failed: {outcome!r}", file=sys.stderr)
                continue
            with path.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(outcome, default=float) + "\n")
            spent = (time.monotonic() - start) / 60
            left = spent / number * (len(open_jobs) - number)
            print(
                f"{number}/{len(open_jobs)} {job.key} {spent:.1f} min, {left:.0f} min left",
                file=sys.stderr,
            )
    keys = {job.key for job in jobs}
    return [record for record in records(path) if record["key"] in keys]


def _end_with_parent() -> None:
    """A worker whose parent was killed would otherwise go on with its job."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def _outcomes(
    jobs: Sequence[SomeJob], work: Callable[[SomeJob], Record], workers: int
) -> Iterator[tuple[SomeJob, Record | BaseException]]:
    """Each job with its record, or with what went wrong, as they end.

    Processes are renewed from call to call; `max_tasks_per_child` can wait forever (CPython issue
    115634).
    """
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_parent) as pool:
        pending = {pool.submit(work, job): job for job in jobs}
        for future in as_completed(pending):
            yield pending[future], future.exception() or future.result()
