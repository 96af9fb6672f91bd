"""Gather labelled sets of scans: `circumspect.gathering.gather`."""

from typing import TYPE_CHECKING

from circumspect.lazy_names import lazy_names

if TYPE_CHECKING:
    from circumspect.gathering.gather import objects_for
    from circumspect.gathering.gather_settings import GatherSettings
    from circumspect.gathering.job_pool import JobPool, LocalPool, run_all
    from circumspect.gathering.scanned_object import ScannedObject

__all__ = ["GatherSettings", "JobPool", "LocalPool", "ScannedObject", "objects_for", "run_all"]
# A command says what is gathered before anything is loaded that does.
__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "GatherSettings": "gather_settings",
        "JobPool": "job_pool",
        "LocalPool": "job_pool",
        "ScannedObject": "scanned_object",
        "objects_for": "gather",
        "run_all": "job_pool",
    },
)
