"""Scan after scan, until the set is complete."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from circumspect.gathering.gather_settings import GatherSettings, ScanTask
from circumspect.gathering.job_pool import JobPool
from circumspect.gathering.object_selection import SelectedObject, select_objects
from circumspect.gathering.object_source import sources_of
from circumspect.gathering.simulated_task import Measure, SimulatedTask, scanned
from circumspect.storage import append_line, atomic_open, write_json

Told = Callable[[int, int, str], None]
"""Called with (done, all, the scan that ended) after each scan."""
Progress = Callable[[int, int], None]
"""Called with (done, all)."""


def objects_for(settings: GatherSettings, progress: Progress | None = None) -> list[SelectedObject]:
    """The objects that settings ask for.

    Args:
        settings: What is to be in a set.
        progress: Called with (done, all) while objects are compared.

    Raises:
        InputError: A source can not be read, or they hold too few objects.
    """
    counts = settings.counts
    sources = sources_of(settings.sources, counts)
    return select_objects(sources, settings.classes, counts, progress)


def gather(
    folder: Path,
    settings: GatherSettings,
    objects: Sequence[SelectedObject],
    pool: JobPool,
    measure: Measure | None = None,
    told: Told | None = None,
) -> list[GatheredScan]:
    """Make the scans that are not there yet, in parallel.

    A scan is in the manifest once all its files are there, so that whatever ends the work costs
    the scans under way and nothing else.

    Args:
        folder: Of the set; a set that is there already goes on or grows.
        settings: What is to be in it.
        objects: Those that `objects_for` chose.
        pool: Makes the scans.
        measure: What the simulation knows of a scan's quality; a function of a module.
        told: Hears of progress.

    Returns:
        All scans of the set.

    Raises:
        InputError: The folder holds a set that was gathered otherwise, or has an object in the
            other split.
        MissingExtraError: The simulator is not installed.
        OutputError: A file can not be written, or a scan failed.
    """
    tasks = settings.tasks(objects)
    if is_gathered(folder):
        _require_splits(folder, objects)
    _prepare(folder, settings, tasks)
    done = {scan.scan for scan in read_manifest(folder)}
    open_tasks = [task for task in tasks if task.key not in done]
    count = len(tasks) - len(open_tasks)
    if told is not None:
        told(count, len(tasks), "")
    failed: list[str] = []
    jobs = (_job(task, settings, folder, measure) for task in open_tasks)
    for job, outcome in pool.outcomes(jobs, scanned):
        count += 1
        # Something is wrong with the machine that every scan would meet.
        if isinstance(outcome, MissingExtraError | InputError):
            raise outcome
        if isinstance(outcome, BaseException):
            failed.append(f"{job.key} ({outcome})")
        else:
            append(folder, GatheredScan(**outcome))
        if told is not None:
            told(count, len(tasks), job.key)
    if failed:
        raise OutputError(
            f"{folder}: {len(failed)} scans failed, the first: {failed[0]}; the same command "
            "tries them again"
        )
    return read_manifest(folder)


def _job(
    task: ScanTask, settings: GatherSettings, folder: Path, measure: Measure | None
) -> SimulatedTask:
    thing = task.object
    scan = GatheredScan(
        task.key, thing.name, thing.label, thing.split, task.start_deg, source=thing.source
    )
    return SimulatedTask(scan, thing.mesh(), settings.seed_of(task), settings, folder, measure)


def _require_splits(folder: Path, objects: Sequence[SelectedObject]) -> None:
    """An object of a set that is there already stays in its split."""
    splits = {scan.object: scan.split for scan in read_manifest(folder)}
    for one in objects:
        if splits.get(one.name, one.split) != one.split:
            raise InputError(
                f"{folder}: holds {one.name} in its {splits[one.name]} split, and it is asked "
                f"for in the {one.split} split; take another folder"
            )


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


def _prepare(folder: Path, settings: GatherSettings, tasks: Sequence[ScanTask]) -> None:
    """Begin a set, or see that this one goes on with it, and write down what is asked for."""
    wanted = {**settings.lasting(), "version": __version__}
    asked = [task.key for task in tasks]
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
