"""The simulated room: scenes, rays, a virtual RGB-D camera and the circle it drives."""

from circumspect.simulation.orbit import Orbit
from circumspect.simulation.ray_caster import RayCaster, View
from circumspect.simulation.scene import Scene, Surface, block, floor
from circumspect.simulation.simulated_camera import SimulatedCamera, shaded
from circumspect.simulation.station import Station, looking_at

__all__ = [
    "Orbit",
    "RayCaster",
    "Scene",
    "SimulatedCamera",
    "Station",
    "Surface",
    "View",
    "block",
    "floor",
    "looking_at",
    "shaded",
]
