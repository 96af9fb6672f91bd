"""Occupancy grids in the object's own frame, cylindrical and rectangular (section 3.2)."""

from circumspect.grid.cylindrical_grid import (
    AZIMUTH_AXIS,
    HEIGHT_AXIS,
    RADIUS_AXIS,
    CylindricalGrid,
)
from circumspect.grid.grid import FREE, OCCUPIED, UNKNOWN, Grid, OccupancyGrid
from circumspect.grid.grid_batches import hits_batch, hits_views, trace_views
from circumspect.grid.rectangular_grid import RectangularGrid
from circumspect.grid.spectrum import angular_spectrum, rotate_spectrum, spectrum_orders

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
