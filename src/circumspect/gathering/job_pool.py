"""Run many long jobs in processes; finished jobs are not repeated."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, TypeVar

from circumspect.datasets.worker_pool import worker_pool
from circumspect.errors import InputError
from circumspect.storage import append_line

Record = dict[str, Any]
Outcome = Record | BaseException
EACH = 8
"""Jobs after which a process is replaced."""

_log = logging.getLogger(__name__)


class Job(Protocol):
    """A job with a unique key."""

    @property
    def key(self) -> str:
        """Its name."""
        ...


SomeJob = TypeVar("SomeJob", bound=Job)


def records(path: Path) -> list[Record]:
    """The written records; an incomplete last line is left out."""
    if not path.exists():
        return []
    found = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            found.append(json.loads(line))
        except ValueError:
            _log.warning("%s: a broken line is left out", path)
    return found


def run_all(
    jobs: Sequence[SomeJob],
    work: Callable[[SomeJob], Record],
    path: Path,
    pool: JobPool,
    progress: Callable[[int, int, str], None],
) -> list[Record]:
    """Run the unfinished jobs, appending one JSON line for each as it ends.

    A job that fails for an unknown reason is logged and left for the next run.

    Args:
        jobs: All jobs.
        work: Runs a job; a module-level function.
        path: Of the records.
        pool: Runs the jobs.
        progress: Called with (done, all, key) before the first job and after each.

    Returns:
        The records of all given jobs that are finished.
    """
    done = {record["key"] for record in records(path)}
    open_jobs = [job for job in jobs if job.key not in done]
    path.parent.mkdir(parents=True, exist_ok=True)
    count = len(jobs) - len(open_jobs)
    progress(count, len(jobs), "")
    for job, outcome in pool.outcomes(open_jobs, work):
        count += 1
        if isinstance(outcome, BaseException):
            _log.warning("%s failed: %r", job.key, outcome)
        else:
            append_line(path, json.dumps(outcome, default=float))
        progress(count, len(jobs), job.key)
    keys = {job.key for job in jobs}
    return [record for record in records(path) if record["key"] in keys]


class JobPool(Protocol):
    """Processes that run jobs on this or on other machines."""

    @property
    def name(self) -> str:
        """Description for users."""
        ...

    def outcomes(
        self, jobs: Iterable[SomeJob], work: Callable[[SomeJob], Record]
    ) -> Iterator[tuple[SomeJob, Outcome]]:
        """Each job with its record or exception, as it ends.

        Args:
            jobs: The jobs; taken as processes become free.
            work: Runs a job; a module-level function. It may be called again for a job whose
                process was lost.
        """
        ...


@dataclass(frozen=True)
class LocalPool:
    """Processes of this machine.

    Attributes:
        workers: How many.

    Raises:
        InputError: There is none.
    """

    workers: int

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise InputError(f"--workers {self.workers}: at least one process is needed")

    @property
    def name(self) -> str:
        """See `JobPool.name`."""
        return "1 process" if self.workers == 1 else f"{self.workers} processes"

    def outcomes(
        self, jobs: Iterable[SomeJob], work: Callable[[SomeJob], Record]
    ) -> Iterator[tuple[SomeJob, Outcome]]:
        """See `JobPool.outcomes`.

        Processes are renewed from batch to batch; `max_tasks_per_child` can wait forever (CPython
        issue 115634).
        """
        # One thread per process: more would only wait for each other.
        os.environ.setdefault("OMP_NUM_THREADS", "1")
        waiting = iter(jobs)
        while some := list(islice(waiting, EACH * self.workers)):
            with worker_pool(self.workers) as pool:
                pending = {pool.submit(work, job): job for job in some}
                for future in as_completed(pending):
                    yield pending[future], future.exception() or future.result()
