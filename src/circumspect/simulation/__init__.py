"""Simulation: scenes, ray casting, RGB-D and ceiling cameras, robot and its faults."""

from circumspect.simulation.calibration_views import (
    board_images,
    calibrated,
    displaced,
    surveyed_tags,
)
from circumspect.simulation.camera_faults import (
    Blackout,
    DroppedFrames,
    EqualStamps,
    NanFrame,
    UnorderedFrames,
    WrongUnit,
)
from circumspect.simulation.ceiling import ceiling_cameras
from circumspect.simulation.ceiling_camera import CeilingCamera, CeilingOptics, PlacedPlate
from circumspect.simulation.ceiling_rig import CeilingRig, CeilingTracker
from circumspect.simulation.orbit import CameraMount, Orbit
from circumspect.simulation.pioneer import RobotSettings
from circumspect.simulation.plate import Plate
from circumspect.simulation.point_surface import surface_from_points
from circumspect.simulation.ray_caster import RayCaster, View
from circumspect.simulation.robot_faults import (
    Blocked,
    ClockStartingAt,
    Kidnapped,
    OdometryCovariance,
    OdometryGone,
    OdometryJumping,
    OdometryLagging,
    OdometryOfAnotherEpoch,
    OdometryStuck,
)
from circumspect.simulation.room import Room, room
from circumspect.simulation.scene import (
    Scene,
    Surface,
    block,
    cylinder,
    floor,
    moved_mesh,
    outlines,
)
from circumspect.simulation.simulated_camera import DepthDistortion, SimulatedCamera, shaded
from circumspect.simulation.simulated_robot import GroundTruthRecorder, SimulatedRobot, TrueState
from circumspect.simulation.station import Station, looking_at

__all__ = [
    "Blackout",
    "Blocked",
    "CameraMount",
    "CeilingCamera",
    "CeilingOptics",
    "CeilingRig",
    "CeilingTracker",
    "ClockStartingAt",
    "DepthDistortion",
    "DroppedFrames",
    "EqualStamps",
    "GroundTruthRecorder",
    "Kidnapped",
    "NanFrame",
    "OdometryCovariance",
    "OdometryGone",
    "OdometryJumping",
    "OdometryLagging",
    "OdometryOfAnotherEpoch",
    "OdometryStuck",
    "Orbit",
    "PlacedPlate",
    "Plate",
    "RayCaster",
    "RobotSettings",
    "Room",
    "Scene",
    "SimulatedCamera",
    "SimulatedRobot",
    "Station",
    "Surface",
    "TrueState",
    "UnorderedFrames",
    "View",
    "WrongUnit",
    "block",
    "board_images",
    "calibrated",
    "ceiling_cameras",
    "cylinder",
    "displaced",
    "floor",
    "looking_at",
    "moved_mesh",
    "outlines",
    "room",
    "shaded",
    "surface_from_points",
    "surveyed_tags",
]
