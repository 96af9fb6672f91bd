"""Many scans into one labelled set."""

from circumspect.gathering.gather import gather, objects_for
from circumspect.gathering.gather_settings import GatherSettings
from circumspect.gathering.job_pool import JobPool, LocalPool, run_all
from circumspect.gathering.scanned_object import ScannedObject, scanned_object

__all__ = [
    "GatherSettings",
    "JobPool",
    "LocalPool",
    "ScannedObject",
    "gather",
    "objects_for",
    "run_all",
    "scanned_object",
]
