"""Scan after scan, until the set is complete."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path

from circumspect import __version__
from circumspect.datasets.gathered_set import (
    MANIFEST,
    SETTINGS,
    GatheredScan,
    is_gathered,
    read_manifest,
)
from circumspect.errors import InputError, OutputError
from circumspect.gathering.gather_settings import GatherSettings
from circumspect.gathering.job_pool import outcomes
from circumspect.gathering.simulated_task import Measure, SimulatedTask, scanned
from circumspect.storage import atomic_open, write_json

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
    file = folder / MANIFEST
    try:
        with file.open("a", encoding="utf-8") as stream:
            stream.write(scan.line())
            stream.flush()
            os.fsync(stream.fileno())
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise OutputError(f"{file}: can not be written ({reason})") from error


def begin(folder: Path, settings: Mapping[str, object]) -> None:
    """Begin an empty set.

    Raises:
        InputError: The folder holds something else.
        OutputError: It can not be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: holds something else; give an empty or a new folder")
    write_json(folder / SETTINGS, dict(settings))
    with atomic_open(folder / MANIFEST) as stream:
        stream.write("")


def _prepare(folder: Path, settings: GatherSettings) -> None:
    """Begin a set, or see that this one goes on with it."""
    wanted = {**settings.lasting(), "version": __version__}
    if not is_gathered(folder):
        begin(folder, wanted)
        return
    try:
        there = json.loads((folder / SETTINGS).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(f"{folder / SETTINGS}: can not be read ({error})") from error
    other = [name for name, value in wanted.items() if there.get(name) != value]
    if other:
        raise InputError(
            f"{folder}: was gathered with {other[0]} {there.get(other[0])}, not "
            f"{wanted[other[0]]}; take another folder"
        )
    _mend(folder)


def _mend(folder: Path) -> None:
    """Drop a last line that an interruption cut."""
    text = (folder / MANIFEST).read_text(encoding="utf-8")
    if text and not text.endswith("\n"):
        with atomic_open(folder / MANIFEST) as stream:
            stream.write(text[: text.rfind("\n") + 1])
