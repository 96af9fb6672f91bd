"""The simulated room: scenes, rays, a virtual RGB-D camera, and a robot that carries it."""

from circumspect.simulation.calibration_views import (
    board_images,
    calibrated,
    knocked,
    laid_tags,
)
from circumspect.simulation.camera_faults import (
    Blackout,
    DroppedFrames,
    EqualStamps,
    NanFrame,
    UnorderedFrames,
    WrongUnit,
)
from circumspect.simulation.camera_mount import CameraMount
from circumspect.simulation.ceiling import ceiling_cameras
from circumspect.simulation.ceiling_camera import CeilingCamera, CeilingOptics, Shown
from circumspect.simulation.ceiling_rig import CeilingRig
from circumspect.simulation.ceiling_watch import CeilingWatch
from circumspect.simulation.clock_faults import (
    ClockStartingAt,
    OdometryLagging,
    OdometryOfAnotherEpoch,
)
from circumspect.simulation.depth_distortion import DepthDistortion
from circumspect.simulation.motion_faults import Blocked, Kidnapped
from circumspect.simulation.odometry_faults import (
    OdometryCovariance,
    OdometryGone,
    OdometryJumping,
    OdometryStuck,
)
from circumspect.simulation.orbit import Orbit
from circumspect.simulation.outlines import outlines
from circumspect.simulation.plate import Plate
from circumspect.simulation.point_surface import surface_from_points
from circumspect.simulation.ray_caster import RayCaster, View
from circumspect.simulation.room import Room, room
from circumspect.simulation.scene import Scene, Surface, block, carried, cylinder, floor
from circumspect.simulation.simulated_camera import SimulatedCamera, shaded
from circumspect.simulation.simulated_robot import RobotSettings, SimulatedRobot, Truth
from circumspect.simulation.station import Station, looking_at
from circumspect.simulation.witness import Witness

__all__ = [
    "Blackout",
    "Blocked",
    "CameraMount",
    "CeilingCamera",
    "CeilingOptics",
    "CeilingRig",
    "CeilingWatch",
    "ClockStartingAt",
    "DepthDistortion",
    "DroppedFrames",
    "EqualStamps",
    "Kidnapped",
    "NanFrame",
    "OdometryCovariance",
    "OdometryGone",
    "OdometryJumping",
    "OdometryLagging",
    "OdometryOfAnotherEpoch",
    "OdometryStuck",
    "Orbit",
    "Plate",
    "RayCaster",
    "RobotSettings",
    "Room",
    "Scene",
    "Shown",
    "SimulatedCamera",
    "SimulatedRobot",
    "Station",
    "Surface",
    "Truth",
    "UnorderedFrames",
    "View",
    "Witness",
    "WrongUnit",
    "block",
    "board_images",
    "calibrated",
    "carried",
    "ceiling_cameras",
    "cylinder",
    "floor",
    "knocked",
    "laid_tags",
    "looking_at",
    "outlines",
    "room",
    "shaded",
    "surface_from_points",
]
