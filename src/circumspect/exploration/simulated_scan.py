"""A scan by a simulated robot in a simulated room."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

import numpy as np

from circumspect.classification import Classifier
from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.scan_settings import RoomSettings, ScanSettings
from circumspect.geometry import PinholeCamera, PlanarPose, TriangleMesh
from circumspect.planning import ViewPlanner
from circumspect.recognition import RecognitionPipeline
from circumspect.recording import RecordingRobot, RunRecorder
from circumspect.robot import MobileRobot
from circumspect.sensing import DepthNoise, GroundSegmentation
from circumspect.simulation import (
    CameraMount,
    DepthDistortion,
    GroundTruthRecorder,
    RobotSettings,
    Room,
    SimulatedRobot,
    room,
)
from circumspect.tracking import Tracker, TrackingSettings

CLUTTER = 4
"""Number of other objects in the room."""
ASKEW = float(np.radians(10.0))
"""Maximum heading error of the robot at the start [rad]."""


@dataclass(frozen=True, eq=False)
class SimulatedScan:
    """All parts of a scan, ready to run.

    Attributes:
        scan: The scan loop.
        ground_truth: Records the true poses of the robot.
        room: The simulated room.
        camera: The robot's camera.
        config: Configuration of the run, JSON types.
    """

    scan: ObjectScan
    ground_truth: GroundTruthRecorder
    room: Room
    camera: PinholeCamera
    config: Mapping[str, Any]

    @property
    def pipeline(self) -> RecognitionPipeline:
        """The pipeline of the scan."""
        return self.scan.pipeline

    def recorded(self, recorder: RunRecorder) -> Self:
        """The scan with a robot whose frames are recorded; see `RecordingRobot`."""
        return self.driven_by(RecordingRobot(self.scan.robot, recorder))

    def driven_by(self, robot: MobileRobot) -> Self:
        """The scan, before its start, with another robot, for instance a wrapper."""
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
        faulty: Callable[[GroundTruthRecorder], MobileRobot] | None = None,
        colour: bool = False,
        real_time: bool = False,
    ) -> Self:
        """Place a robot in a room with an object.

        Args:
            mesh: The object, standing on z = 0 [m].
            world: Settings of the room and of the robot's errors.
            driving: Settings of the scan.
            planner: Chooses views.
            classifier: Classifies the object.
            config: Description of the run, with at least "seed" and "start_deg".
            camera: The camera; None means the Xtion PRO.
            faulty: Wraps the robot in a faulty one.
            colour: Whether the camera also renders colour images, which takes time.
            real_time: Whether the simulation is limited to real time.

        Raises:
            InputError: A setting is invalid, or the object is too large.
            MissingExtraError: The simulation is not installed.
        """
        seed, camera, noise = int(config["seed"]), camera or PinholeCamera.xtion(), DepthNoise()
        place = room(mesh, seed, camera, world.mast_height, noise, CLUTTER * world.clutter)
        robot = _robot(place, world, config, camera, noise, colour, real_time)
        ground_truth = GroundTruthRecorder(robot)
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
            "grid": classifier.input_spec.to_dict(),
        }
        scan = ObjectScan(
            faulty(ground_truth) if faulty else ground_truth, pipeline, planner, driving
        )
        return cls(scan, ground_truth, place, camera, full_config)


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
