"""Where long jobs are done: `--workers` and `--cluster`."""

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
    """Processes of this machine, or those of a Ray cluster while a block runs.

    Args:
        workers: Processes of this machine; None means one a core.
        cluster: "auto" or the address of a cluster; None means this machine.

    Raises:
        InputError: Both are given, there is no cluster, or no process.
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
    """A path or URL as processes elsewhere are given it.

    Processes of a cluster have another working directory.

    Args:
        cluster: As for `opened_pool`.
        place: A path or URL.
    """
    return place if cluster is None or "://" in place else str(Path(place).resolve())
