"""Occupancy grids in the object's own frame, cylindrical and rectangular (section 3.2)."""

from circumspect.grid.cylindrical_grid import (
    AZIMUTH_AXIS,
    HEIGHT_AXIS,
    RADIUS_AXIS,
    CylindricalGrid,
)
from circumspect.grid.grid import Grid
from circumspect.grid.hits_batch import hits_batch
from circumspect.grid.occupancy_grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from circumspect.grid.rectangular_grid import RectangularGrid
from circumspect.grid.spectrum import angular_spectrum, rotate_spectrum, spectrum_orders
from circumspect.grid.view_grids import hits_views, trace_views

__all__ = [
    "AZIMUTH_AXIS",
    "FREE",
    "HEIGHT_AXIS",
    "OCCUPIED",
    "RADIUS_AXIS",
    "UNKNOWN",
    "CylindricalGrid",
    "Grid",
    "OccupancyGrid",
    "RectangularGrid",
    "angular_spectrum",
    "hits_batch",
    "hits_views",
    "rotate_spectrum",
    "spectrum_orders",
    "trace_views",
]
