"""A small robot's world: a box in a room, tiny images, true poses, coarse steps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from volume_classifier import VolumeClassifier

from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.scan_settings import ScanSettings
from circumspect.geometry import PinholeCamera, PlanarPose, TriangleMesh
from circumspect.planning import CirclePlanner, ViewPlanner
from circumspect.recognition import RecognitionPipeline
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import DepthNoise, GroundSegmentation, RgbdFrame
from circumspect.simulation import CameraMount, Scene, SimulatedRobot, Surface, block
from circumspect.tracking import KnownPoses, PoseEstimator

CAMERA = PinholeCamera(160, 120, 142.5, 142.5, 79.5, 59.5)
BOX = block((-0.25, -0.2, 0.0), (0.25, 0.2, 0.6))
NOTHING = block((8.0, 8.0, 0.0), (8.1, 8.1, 0.1))
QUICK = ScanSettings(
    speed=0.2,
    frame_interval=1.0,
    turn_between_frames=float(np.radians(15.0)),
    patience=3.0,
    max_blocks=2,
    max_frames=300,
)


class TruePoses(WrappedRobot):
    """A robot whose frames carry their true poses."""

    def __init__(self, robot: SimulatedRobot, outer: MobileRobot | None = None) -> None:
        super().__init__(outer or robot)
        self.simulated = robot

    def _on_frame(self, frame: RgbdFrame) -> RgbdFrame:
        return frame.at(self.simulated.truth().T_map_camera)


def start(azimuth_deg: float = 20.0, away: float = 1.3, askew: float = 0.0) -> PlanarPose:
    """On a circle round the origin, the object on the left, turned by `askew` [rad] from that."""
    azimuth = np.radians(azimuth_deg)
    x, y = away * np.cos(azimuth), away * np.sin(azimuth)
    return PlanarPose(x, y, azimuth + np.pi / 2 + askew)


def wall(low: tuple[float, float], high: tuple[float, float]) -> Surface:
    return Surface("wall", block((*low, 0.0), (*high, 1.5)))


def scan(
    *,
    planner: ViewPlanner | None = None,
    mesh: TriangleMesh = BOX,
    others: tuple[Surface, ...] = (),
    pose: PlanarPose | None = None,
    settings: ScanSettings = QUICK,
    poses: PoseEstimator | None = None,
    fault: Callable[[SimulatedRobot], MobileRobot] | None = None,
    seed: int = 0,
    camera: PinholeCamera = CAMERA,
    classifier: VolumeClassifier | None = None,
) -> ObjectScan:
    robot = SimulatedRobot(
        Scene.with_object(mesh, *others),
        pose or start(),
        CameraMount(),
        intrinsics=camera,
        noise=DepthNoise(),
        seed=seed,
    )
    seen = TruePoses(robot, None if fault is None else fault(robot))
    pipeline = RecognitionPipeline(
        GroundSegmentation(min_pixels=20), poses or KnownPoses(),
        classifier or VolumeClassifier(),
    )  # fmt: skip
    return ObjectScan(seen, pipeline, planner or CirclePlanner(), settings)
