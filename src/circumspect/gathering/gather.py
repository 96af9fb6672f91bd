"""Gather the scans of a set."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from circumspect import __version__
from circumspect.datasets.gathered_set import ASKED, GatheredScan
from circumspect.errors import InputError, MissingExtraError, OutputError
from circumspect.gathering.gather_settings import GatherSettings, ScanTask
from circumspect.gathering.job_pool import JobPool
from circumspect.gathering.object_selection import SelectedObject, select_objects
from circumspect.gathering.object_source import sources_of
from circumspect.gathering.set_place import SetPlace
from circumspect.gathering.simulated_task import Measure, SimulatedTask, scanned

JobProgress = Callable[[int, int, str], None]
"""Called with (done, all, name of the finished scan) after each scan."""
Progress = Callable[[int, int], None]
"""Called with (done, all)."""


def objects_for(settings: GatherSettings, progress: Progress | None = None) -> list[SelectedObject]:
    """Select the objects for the settings.

    Args:
        settings: Of the set.
        progress: Called with (done, all) while objects are compared.

    Raises:
        InputError: A source is unreadable, or the sources hold too few objects.
    """
    counts = settings.counts
    sources = sources_of(settings.sources, counts)
    return select_objects(sources, settings.classes, counts, progress)


def gather(
    place: SetPlace,
    settings: GatherSettings,
    objects: Sequence[SelectedObject],
    pool: JobPool,
    measure: Measure | None = None,
    progress: JobProgress | None = None,
) -> list[GatheredScan]:
    """Make the missing scans in parallel.

    A scan enters the manifest when all its files are complete, so an interruption loses only the
    scans in progress.

    Args:
        place: Of the set; an existing set grows.
        settings: Of the set.
        objects: Result of `objects_for`.
        pool: Runs the jobs.
        measure: Measures a scan against the simulation; a module-level function.
        progress: Receives the progress.

    Returns:
        All scans of the set.

    Raises:
        InputError: The place holds a set with other settings, or has an object in the other split.
        MissingExtraError: The simulator is not installed.
        OutputError: A file cannot be written, or a scan failed.
    """
    tasks = settings.tasks(objects)
    there = place.scans()
    _require_splits(place, there, objects)
    _prepare(place, settings, tasks)
    done = {scan.scan for scan in there}
    open_tasks = [task for task in tasks if task.key not in done]
    count = len(tasks) - len(open_tasks)
    if progress is not None:
        progress(count, len(tasks), "")
    failed: list[str] = []
    jobs = (_job(task, settings, place, measure) for task in open_tasks)
    for job, outcome in pool.outcomes(jobs, scanned):
        count += 1
        # The machine has an error that every scan would meet.
        if isinstance(outcome, MissingExtraError | InputError):
            raise outcome
        if isinstance(outcome, BaseException):
            failed.append(f"{job.key} ({outcome})")
        else:
            place.add(GatheredScan(**outcome))
        if progress is not None:
            progress(count, len(tasks), job.key)
    if failed:
        raise OutputError(
            f"{place.name}: {len(failed)} scans failed, the first: {failed[0]}; the same command "
            "tries them again"
        )
    place.finish()
    return place.scans()


def _job(
    task: ScanTask, settings: GatherSettings, place: SetPlace, measure: Measure | None
) -> SimulatedTask:
    selected = task.object
    scan = GatheredScan(
        task.key,
        selected.name,
        selected.label,
        selected.split,
        task.start_deg,
        source=selected.source,
    )
    return SimulatedTask(
        scan, selected.mesh(), settings.seed_of(task), settings, place.name, measure
    )


def _require_splits(
    place: SetPlace, scans: Sequence[GatheredScan], objects: Sequence[SelectedObject]
) -> None:
    """Check that objects of an existing set stay in their split."""
    splits = {scan.object: scan.split for scan in scans}
    for one in objects:
        if splits.get(one.name, one.split) != one.split:
            raise InputError(
                f"{place.name}: holds {one.name} in its {splits[one.name]} split, but is "
                f"requested in the {one.split} split; take another folder"
            )


def _prepare(place: SetPlace, settings: GatherSettings, tasks: Sequence[ScanTask]) -> None:
    """Begin a set, or check that the settings continue it, and write the requested scans."""
    wanted = {**settings.lasting(), "version": __version__}
    requested = [task.key for task in tasks]
    if not place.is_begun():
        place.begin({**wanted, ASKED: requested})
        return
    there = place.settings()
    other = [name for name, value in wanted.items() if there.get(name) != value]
    if other:
        raise InputError(
            f"{place.name}: was gathered with {other[0]} {there.get(other[0])}, not "
            f"{wanted[other[0]]}; take another folder"
        )
    before = there.get(ASKED)
    known = before if isinstance(before, list) else []
    both = list(dict.fromkeys([*known, *requested]))
    if both != known:
        place.write_settings({**there, ASKED: both})
