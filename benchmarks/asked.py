"""Which records a table is made of: those of the settings that its command was given."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Iterable, Sequence
from typing import Any

from benchmarks.older_keys import with_todays_keys
from circumspect.gathering.job_pool import Job


def of_jobs(found: Iterable[dict[str, Any]], jobs: Iterable[Job]) -> list[dict[str, Any]]:
    """The records of some jobs, with the keys of today.

    Beside them a file may hold scans of other settings.
    """
    keys = {job.key for job in jobs}
    return [with_todays_keys(record) for record in found if record["key"] in keys]


def command_with(command: str, given: Namespace, usual: Namespace, settings: Sequence[str]) -> str:
    """A command with those of its settings that are not as usual."""
    values = {name: getattr(given, name) for name in settings}
    flags = [
        f" --{name.replace('_', '-')} {_as_typed(value)}"
        for name, value in values.items()
        if value != getattr(usual, name)
    ]
    return command + "".join(flags)


def _as_typed(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"
