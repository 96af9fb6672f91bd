"""Selection of the records of a table by the settings of its command."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable, Sequence
from typing import Any

from benchmarks.older_keys import with_current_keys
from circumspect.gathering.job_pool import Job


def records_of_jobs(found: Iterable[dict[str, Any]], jobs: Iterable[Job]) -> list[dict[str, Any]]:
    """The records of some jobs, with current keys.

    A file may also contain scans with other settings.
    """
    keys = {job.key for job in jobs}
    return [with_current_keys(record) for record in found if record["key"] in keys]


def command_with_flags(
    command: str, given: Namespace, defaults: Namespace, settings: Sequence[str]
) -> str:
    """A command with those of its settings that differ from the defaults."""
    values = {name: getattr(given, name) for name in settings}
    flags = [
        f" --{name.replace('_', '-')} {_as_typed(value)}"
        for name, value in values.items()
        if value != getattr(defaults, name)
    ]
    return command + "".join(flags)


def _as_typed(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"
