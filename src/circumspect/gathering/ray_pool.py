"""Jobs on a Ray cluster."""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import islice
from typing import Any, Self

from circumspect import __version__
from circumspect.errors import InputError, MissingExtraError
from circumspect.gathering.job_pool import Outcome, Record, SomeJob

RETRIES = 5
"""Number of retries of a job whose process or node was lost."""
CONNECT_S = 10.0
"""Timeout for the cluster's head [s]."""
IN_FLIGHT = 2
"""Submitted jobs per core: one runs, one waits."""


class RayPool:
    """Processes of a Ray cluster: one job per core.

    A job whose process or node is lost is restarted elsewhere. Nodes may join at any time.
    """

    def __init__(self, ray: Any) -> None:
        """Use a cluster that the module `ray` is connected to; see `connected`."""
        self._ray = ray

    @classmethod
    @contextmanager
    def connected(cls, address: str) -> Iterator[Self]:
        """Connect to a cluster while a block runs.

        Args:
            address: "auto" for the cluster of this machine, else HOST:PORT.

        Raises:
            MissingExtraError: Ray is not installed.
            InputError: There is no cluster.
        """
        os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
        try:
            import ray
        except ImportError as error:
            raise MissingExtraError("ray", "cluster") from error
        try:
            _require_an_answer(address)
            ray.init(address, log_to_driver=False, logging_level=logging.ERROR)
        except (OSError, RuntimeError, ValueError) as error:
            raise InputError(
                f"no Ray cluster at {address}; `ray start --head` on one machine begins one"
            ) from error
        try:
            yield cls(ray)
        finally:
            # Unfinished jobs belong to this connection and end with it.
            ray.shutdown()

    @property
    def name(self) -> str:
        """See `JobPool.name`; counts the nodes that are alive now."""
        nodes = sum(bool(node["Alive"]) for node in self._ray.nodes())
        return f"{nodes} node{'s' * (nodes != 1)}, {self._cores} cores"

    @property
    def _cores(self) -> int:
        """Cores of all nodes, now."""
        return max(1, int(self._ray.cluster_resources().get("CPU", 1)))

    def outcomes(
        self, jobs: Iterable[SomeJob], work: Callable[[SomeJob], Record]
    ) -> Iterator[tuple[SomeJob, Outcome]]:
        """See `JobPool.outcomes`."""
        ray, waiting = self._ray, iter(jobs)
        remote = ray.remote(num_cpus=1, max_retries=RETRIES)(_done)
        pending: dict[Any, SomeJob] = {}
        while True:
            room = IN_FLIGHT * self._cores - len(pending)
            for job in islice(waiting, max(room, 0)):
                pending[remote.remote(work, job, __version__)] = job
            if not pending:
                return
            (ready, *_), _ = ray.wait(list(pending), num_returns=1)
            yield pending.pop(ready), self._outcome(ready)

    def _outcome(self, ready: Any) -> Outcome:
        try:
            return self._ray.get(ready)
        except self._ray.exceptions.RayTaskError as error:
            return _cause_of(error.cause) if isinstance(error.cause, Exception) else error
        except self._ray.exceptions.RayError as error:
            return error


def _require_an_answer(address: str) -> None:
    """Check the address; Ray itself would try for two minutes.

    Raises:
        OSError: Nothing listens there.
        ValueError: The address is invalid.
    """
    if address != "auto":
        host, _, port = address.rpartition(":")
        socket.create_connection((host, int(port)), CONNECT_S).close()


def _cause_of(cause: Exception) -> Exception:
    """The exception from a node; a node without the program cannot report that itself."""
    if isinstance(cause, ModuleNotFoundError | AttributeError) and "circumspect" in str(cause):
        return InputError(f"a node has no circumspect {__version__} installed ({cause})")
    return cause


def _done(work: Callable[[Any], Record], job: Any, version: str) -> Record:
    """Run a job on a node.

    Raises:
        InputError: The node has another version.
    """
    if version != __version__:
        raise InputError(
            f"the node {socket.gethostname()} has circumspect {__version__}, not {version}"
        )
    return work(job)
