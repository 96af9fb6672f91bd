"""The scan loop of section 3.1: drive, look, plan, stop."""

from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.exploration.view_record import ViewRecord

__all__ = ["ObjectScan", "ScanSettings", "ViewRecord"]
