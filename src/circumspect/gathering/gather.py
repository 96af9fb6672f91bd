"""Scan after scan, until the set is complete."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from circumspect import __version__
from circumspect.datasets.gathered_set import (
    ASKED,
    MANIFEST,
    SETTINGS,
    GatheredScan,
    is_gathered,
    read_manifest,
    read_settings,
)
from circumspect.errors import InputError, MissingExtraError, OutputError
from circumspect.gathering.gather_settings import GatherSettings
from circumspect.gathering.job_pool import outcomes
from circumspect.gathering.simulated_task import Measure, SimulatedTask, scanned
from circumspect.storage import append_line, atomic_open, write_json

Told = Callable[[int, int, str], None]
"""Called with (done, all, the scan that ended) after each scan."""


def gather(
    folder: Path,
    settings: GatherSettings,
    workers: int,
    measure: Measure | None = None,
    told: Told | None = None,
) -> list[GatheredScan]:
    """Make the scans that are not there yet, in parallel processes.

    A scan is in the manifest once all its files are there, so that whatever ends the work costs
    the scans under way and nothing else.

    Args:
        folder: Of the set; a set that is there already goes on or grows.
        settings: What is to be in it.
        workers: Processes.
        measure: What the simulation knows of a scan's quality; a function of a module.
        told: Hears of progress.

    Returns:
        All scans of the set.

    Raises:
        InputError: The folder holds a set that was gathered otherwise.
        MissingExtraError: The simulator is not installed.
        OutputError: A file can not be written.
    """
    _prepare(folder, settings)
    done = {scan.scan for scan in read_manifest(folder)}
    tasks = [task for task in settings.tasks if task.key not in done]
    jobs = [SimulatedTask(task, settings, folder, measure) for task in tasks]
    count = before = len(settings.tasks) - len(jobs)
    if told is not None:
        told(before, len(settings.tasks), "")
    failed: list[str] = []
    for job, outcome in outcomes(jobs, scanned, workers):
        count += 1
        if isinstance(outcome, MissingExtraError):
            raise outcome
        if isinstance(outcome, BaseException):
            failed.append(f"{job.key} ({outcome})")
        else:
            append(folder, GatheredScan(**outcome))
        if told is not None:
            told(count, len(settings.tasks), job.key)
    if failed:
        raise OutputError(
            f"{folder}: {len(failed)} scans failed, the first: {failed[0]}; the same command "
            "tries them again"
        )
    return read_manifest(folder)


def append(folder: Path, scan: GatheredScan) -> None:
    """Add a scan to the manifest.

    Raises:
        OutputError: It can not be written.
    """
    append_line(folder / MANIFEST, scan.line().rstrip("\n"), durable=True)


def begin(folder: Path, settings: Mapping[str, object]) -> None:
    """Begin an empty set.

    Raises:
        InputError: The folder holds something else.
        OutputError: It can not be written.
    """
    require_free(folder)
    write_json(folder / SETTINGS, dict(settings))
    with atomic_open(folder / MANIFEST) as stream:
        stream.write("")


def require_free(folder: Path) -> None:
    """Find out whether a set can begin in a folder.

    Raises:
        InputError: It holds something else.
    """
    if folder.exists() and not _is_free(folder):
        raise InputError(f"{folder}: holds something else; give an empty or a new folder")


def _is_free(folder: Path) -> bool:
    """Whether it is empty, or holds only the settings of a set that was interrupted at once."""
    if not folder.is_dir():
        return False
    names = [file.name for file in folder.iterdir()]
    if names == [SETTINGS]:
        return bool(read_settings(folder).keys() & {"version", "source"})
    return not names


def _prepare(folder: Path, settings: GatherSettings) -> None:
    """Begin a set, or see that this one goes on with it, and write down what is asked for."""
    wanted = {**settings.lasting(), "version": __version__}
    asked = [task.key for task in settings.tasks]
    if not is_gathered(folder):
        begin(folder, {**wanted, ASKED: asked})
        return
    there = read_settings(folder)
    other = [name for name, value in wanted.items() if there.get(name) != value]
    if other:
        raise InputError(
            f"{folder}: was gathered with {other[0]} {there.get(other[0])}, not "
            f"{wanted[other[0]]}; take another folder"
        )
    before = there.get(ASKED)
    known = before if isinstance(before, list) else []
    both = list(dict.fromkeys([*known, *asked]))
    if both != known:
        write_json(folder / SETTINGS, {**there, ASKED: both})
