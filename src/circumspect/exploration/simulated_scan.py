"""A scan by a simulated robot in a room."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

import numpy as np

from circumspect.classification import Classifier
from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.geometry import PinholeCamera, PlanarPose, TriangleMesh
from circumspect.planning import ViewPlanner
from circumspect.recognition import RecognitionPipeline
from circumspect.recording import RecordingRobot, RunRecorder
from circumspect.robot import MobileRobot
from circumspect.sensing import DepthNoise, GroundSegmentation
from circumspect.simulation import (
    CameraMount,
    DepthDistortion,
    RobotSettings,
    Room,
    SimulatedRobot,
    Witness,
    room,
)
from circumspect.tracking import Tracker, TrackingSettings

CLUTTER = 4
"""Things that stand about."""
ASKEW = float(np.radians(10.0))
"""The robot starts up to this far from facing the object [rad]."""


@dataclass(frozen=True)
class RoomSettings:
    """The world around the object.

    Attributes:
        slip: Share of the wheels' travel that does not become motion.
        clutter: Whether other things stand about.
        mast_height: Of the camera [m].
        tilt_deg: How far it looks down [degrees]; None for what the object asks for.
        wheel_error: Share by which the right wheel is larger than the odometry believes.
        bump_height: The highest ridge on the floor [m].
        distorted: Whether the camera's depth is distorted as `DepthNoise` describes.
    """

    slip: float = 0.05
    clutter: bool = True
    mast_height: float = 1.2
    tilt_deg: float | None = None
    wheel_error: float = 0.0
    bump_height: float = 0.0
    distorted: bool = False


@dataclass(frozen=True, eq=False)
class SimulatedScan:
    """All parts of a scan, ready to run.

    Attributes:
        scan: The loop.
        witness: Knows the true poses of the robot.
        room: The world.
        camera: The robot's.
        config: What the run was started with, JSON types.
    """

    scan: ObjectScan
    witness: Witness
    room: Room
    camera: PinholeCamera
    config: Mapping[str, Any]

    @property
    def pipeline(self) -> RecognitionPipeline:
        """The pipeline of the scan."""
        return self.scan.pipeline

    def recorded(self, recorder: RunRecorder) -> Self:
        """The same scan with a robot whose frames are recorded; see `RecordingRobot`."""
        return self.driven_by(RecordingRobot(self.scan.robot, recorder))

    def driven_by(self, robot: MobileRobot) -> Self:
        """The same scan, not yet begun, with another robot, as one that wraps its own."""
        scan = ObjectScan(robot, self.pipeline, self.scan.planner, self.scan.settings)
        return replace(self, scan=scan)

    @classmethod
    def prepared(
        cls,
        mesh: TriangleMesh,
        world: RoomSettings,
        driving: ScanSettings,
        planner: ViewPlanner,
        classifier: Classifier,
        config: Mapping[str, Any],
        camera: PinholeCamera | None = None,
        faulty: Callable[[Witness], MobileRobot] | None = None,
        colour: bool = False,
        real_time: bool = False,
    ) -> Self:
        """Place a robot in a room with an object.

        Args:
            mesh: The object, standing on z = 0 [m].
            world: The room and the robot's faults.
            driving: How it drives and looks.
            planner: Chooses views.
            classifier: Classifies the object.
            config: "seed", "start_deg" and other entries that describe the run.
            camera: None means the Xtion PRO.
            faulty: Wraps the robot in a faulty one.
            colour: The camera makes colour images, too, which takes time.
            real_time: The simulation goes no faster than the world.

        Raises:
            InputError: A setting makes no sense, or the object is too large.
            MissingExtraError: The simulation is not installed.
        """
        seed, camera, noise = int(config["seed"]), camera or PinholeCamera.xtion(), DepthNoise()
        place = room(mesh, seed, camera, world.mast_height, noise, CLUTTER * world.clutter)
        robot = _robot(place, world, config, camera, noise, colour, real_time)
        witness = Witness(robot)
        segmentation = GroundSegmentation(noise=noise)
        tracking = TrackingSettings.for_noise(noise if world.distorted else _undistorted(noise))
        pipeline = RecognitionPipeline(segmentation, Tracker(settings=tracking), classifier)
        full_config = {
            **config,
            "room": asdict(world),
            "mount": asdict(robot.mount),
            "scan": asdict(driving),
            "segmentation": asdict(segmentation),
            "tracking": asdict(tracking),
            "model": asdict(pipeline.model.settings),
            "grid": classifier.recipe.to_dict(),
        }
        scan = ObjectScan(faulty(witness) if faulty else witness, pipeline, planner, driving)
        return cls(scan, witness, place, camera, full_config)


def _robot(
    place: Room,
    world: RoomSettings,
    config: Mapping[str, Any],
    camera: PinholeCamera,
    noise: DepthNoise,
    colour: bool,
    real_time: bool,
) -> SimulatedRobot:
    """The robot at its start; arguments as in `SimulatedScan.prepared`."""
    seed, mount = int(config["seed"]), place.mount
    if world.tilt_deg is not None:
        mount = CameraMount(world.mast_height, float(np.radians(world.tilt_deg)))
    settings = RobotSettings(
        slip=world.slip, wheel_radius_error=world.wheel_error, bump_height=world.bump_height
    )
    askew = float(np.random.default_rng(seed).uniform(-ASKEW, ASKEW))
    start = place.start(float(config["start_deg"])) @ PlanarPose(0.0, 0.0, askew)
    return SimulatedRobot(
        place.scene, start, mount, settings, camera, noise, seed, colour,
        1.0 if real_time else None,
        DepthDistortion.drawn(noise, camera, seed) if world.distorted else None,
    )  # fmt: skip


def _undistorted(noise: DepthNoise) -> DepthNoise:
    """The noise of a camera without systematic errors of its disparity."""
    return replace(noise, systematic_disparity=0.0)
