"""Scan-to-map registration by point-to-plane ICP with a prior, and free-space violations."""

from circumspect.registration.free_space import (
    FreeSpace,
    violated_count,
    violated_points,
    violation_ratio,
)
from circumspect.registration.point_to_plane import PointToPlaneProblem, Weighting, linearised
from circumspect.registration.registration import Registration, RegistrationSettings, register
from circumspect.registration.scan import DownsamplingSettings, Scan
from circumspect.registration.scan_surface import CompactSurface, ScanSurface
from circumspect.registration.surface_map import SurfaceMap

__all__ = [
    "CompactSurface",
    "DownsamplingSettings",
    "FreeSpace",
    "PointToPlaneProblem",
    "Registration",
    "RegistrationSettings",
    "Scan",
    "ScanSurface",
    "SurfaceMap",
    "Weighting",
    "linearised",
    "register",
    "violated_count",
    "violated_points",
    "violation_ratio",
]
