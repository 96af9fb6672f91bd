"""The scan loop of section 3.1: drive, look, plan, stop."""

from typing import TYPE_CHECKING

from circumspect.lazy_names import lazy_names

if TYPE_CHECKING:
    from circumspect.exploration.object_scan import ObjectScan
    from circumspect.exploration.scan_settings import RoomSettings, ScanSettings
    from circumspect.exploration.view_record import ViewRecord

__all__ = ["ObjectScan", "RoomSettings", "ScanSettings", "ViewRecord"]
# Commands read the settings of a scan before the heavy modules are loaded.
__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "ObjectScan": "object_scan",
        "RoomSettings": "scan_settings",
        "ScanSettings": "scan_settings",
        "ViewRecord": "view_record",
    },
)
