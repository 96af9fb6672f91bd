"""Pool of processes for long jobs: `--workers` and `--cluster`."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from circumspect.errors import InputError

if TYPE_CHECKING:
    from circumspect.gathering import JobPool


@contextmanager
def opened_pool(workers: int | None, cluster: str | None) -> Iterator[JobPool]:
    """Open processes of this machine, or of a Ray cluster, for a block.

    Args:
        workers: Number of processes of this machine; None means one per core.
        cluster: "auto" or the address of a cluster; None means this machine.

    Raises:
        InputError: Both are given, there is no cluster, or there is no process.
        MissingExtraError: Ray is not installed.
    """
    from circumspect.gathering import LocalPool

    if cluster is None:
        yield LocalPool(os.cpu_count() or 1 if workers is None else workers)
        return
    if workers is not None:
        raise InputError("--workers is for this machine; a --cluster has as many as it has cores")
    from circumspect.gathering.ray_pool import RayPool

    with RayPool.connected(cluster) as pool:
        yield pool


def seen_from(cluster: str | None, place: str) -> str:
    """A path or URL for worker processes; absolute for a cluster.

    Processes of a cluster have another working directory.

    Args:
        cluster: See `opened_pool`.
        place: A path or URL.
    """
    return place if cluster is None or "://" in place else str(Path(place).resolve())
