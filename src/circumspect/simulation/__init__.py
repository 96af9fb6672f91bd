"""The simulated room: scenes, rays, a virtual RGB-D camera, and a robot that carries it."""

from circumspect.simulation.camera_mount import CameraMount
from circumspect.simulation.orbit import Orbit
from circumspect.simulation.ray_caster import RayCaster, View
from circumspect.simulation.room import Room, room
from circumspect.simulation.scene import Scene, Surface, block, cylinder, floor
from circumspect.simulation.simulated_camera import SimulatedCamera, shaded
from circumspect.simulation.simulated_robot import RobotSettings, SimulatedRobot, Truth
from circumspect.simulation.station import Station, looking_at

__all__ = [
    "CameraMount",
    "Orbit",
    "RayCaster",
    "RobotSettings",
    "Room",
    "Scene",
    "SimulatedCamera",
    "SimulatedRobot",
    "Station",
    "Surface",
    "Truth",
    "View",
    "block",
    "cylinder",
    "floor",
    "looking_at",
    "room",
    "shaded",
]
