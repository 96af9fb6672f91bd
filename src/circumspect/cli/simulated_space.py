"""A simulated robot under simulated ceiling cameras, as `locate simulate` drives it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.cli.located_run import LocatedRun
from circumspect.errors import CircumspectError, InputError
from circumspect.evaluation.space_error import SpaceError, space_error
from circumspect.furniture import make_furniture
from circumspect.geometry import PlanarPose, Trajectory, wrapped, write_tum
from circumspect.localization import (
    Calibration,
    CeilingImage,
    CharucoBoard,
    IntelligentSpace,
    SpaceFix,
    SpaceTrack,
    Survey,
    write_calibration,
)
from circumspect.robot import PathFollower, Velocity
from circumspect.simulation import (
    CeilingRig,
    RobotSettings,
    Room,
    Shown,
    SimulatedRobot,
    calibrated,
    ceiling_cameras,
    knocked,
    laid_tags,
    outlines,
    room,
)

KNOCK = RigidTransform.from_components([0.04, 0.0, 0.0], Rotation.from_rotvec([0.0, 0.0, 0.01]))
"""What becomes of a camera that somebody knocks, in its own frame."""
AHEAD = float(np.radians(50.0))
"""The robot steers to a place so far ahead on its circle [rad]."""
TICK = 0.02
TELL_EVERY = 10.0
"""Between two lines of progress [s of the robot's clock]."""
SIMULATED = CALIBRATION, TRUTH, ODOMETRY = ("calibration.json", "truth.txt", "odometry.txt")
"""Files of a run that the simulation knows, and nobody else."""


@dataclass(frozen=True)
class SpaceSetup:
    """What is simulated.

    Attributes:
        cameras: How many.
        ceiling: Their height [m].
        speed: Of the robot [m/s].
        seconds: How long it drives at most.
        rate: Images a second of each camera.
        slip: Share of the wheels' travel that does not become motion.
        calibrate: "all", "extrinsics" or "none": what is calibrated from images.
        moved: Name of a camera that is knocked aside after calibration.
        seed: Of all chance.
        size: Of the images [px].

    Raises:
        InputError: A value makes no sense.
    """

    cameras: int = 4
    ceiling: float = 3.0
    speed: float = 0.2
    seconds: float = 60.0
    rate: float = 10.0
    slip: float = 0.05
    calibrate: str = "extrinsics"
    moved: str | None = None
    seed: int = 0
    size: tuple[int, int] = (1280, 960)

    def __post_init__(self) -> None:
        if not (0 < self.speed <= 1 and 0 < self.seconds <= 3600):
            raise InputError(f"no robot drives {self.speed} m/s for {self.seconds} s; try 0.2, 60")
        if not 0.1 <= self.rate <= 1 / TICK:
            raise InputError(f"--rate {self.rate}: from 0.1 to {1 / TICK:g} images a second")
        if not all(64 <= side <= 8192 for side in self.size):
            raise InputError(f"--size {self.size[0]} {self.size[1]}: from 64 to 8192 pixels")
        if not 1 <= self.cameras <= 64:
            raise InputError(f"--cameras {self.cameras}: give 1 to 64")


@dataclass(eq=False)
class SimulatedSpace:
    """Robot, room and cameras, and what came of them.

    Attributes:
        setup: What is simulated.
        place: The room.
        robot: The robot.
        rig: The cameras as they hang.
        survey: Of tags on the floor.
        laid: Those tags.
        calibration: How the cameras are believed to hang.
        space: What locates.
        fixes: What it said.
        milliseconds: What each answer took.
    """

    setup: SpaceSetup
    place: Room
    robot: SimulatedRobot
    rig: CeilingRig
    survey: Survey
    laid: tuple[Shown, ...]
    calibration: Calibration
    space: IntelligentSpace
    fixes: list[SpaceFix] = field(default_factory=list)
    milliseconds: list[float] = field(default_factory=list)
    _truth: list[tuple[float, RigidTransform]] = field(default_factory=list)
    _wheels: list[tuple[float, PlanarPose]] = field(default_factory=list)

    @classmethod
    def prepared(cls, setup: SpaceSetup) -> Self:
        """Furnish a room, hang cameras, and calibrate them.

        Raises:
            InputError: A setting makes no sense, or no camera of the name that was knocked.
            MissingExtraError: The simulation, OpenCV or pupil-apriltags is not installed.
        """
        seed = setup.seed
        place = room(make_furniture("chair", seed), seed)
        middle = np.array(place.orbit.centre_xy)
        low, high = middle - place.lane_radius, middle + place.lane_radius
        hung = ceiling_cameras(low, high, setup.cameras, setup.ceiling, size=setup.size, seed=seed)
        if setup.moved is not None and setup.moved not in [camera.name for camera in hung]:
            names = ", ".join(camera.name for camera in hung)
            raise InputError(f"--moved {setup.moved}: no such camera; there are {names}")
        rig = CeilingRig(hung, place.scene, seed=seed)
        survey, laid = laid_tags(low, high, rng=seed)
        if setup.calibrate == "none":
            calibration = Calibration.of(hung, rig.mount)
        else:
            board = CharucoBoard() if setup.calibrate == "all" else None
            calibration = calibrated(rig, survey, laid, board, seed)
        if setup.moved is not None:
            after = [knocked(c, KNOCK) if c.name == setup.moved else c for c in hung]
            rig = CeilingRig(after, place.scene, seed=seed)
        start = place.start(float(np.random.default_rng(seed).uniform(0, 360)))
        settings = RobotSettings(slip=setup.slip)
        robot = SimulatedRobot(place.scene, start, place.mount, settings, seed=seed)
        space = IntelligentSpace(calibration.cameras, rig.mount)
        return cls(setup, place, robot, rig, survey, laid, calibration, space)

    def drive(
        self,
        say: Callable[[str], None] = lambda _: None,
        taken: Callable[[Sequence[CeilingImage]], None] = lambda _: None,
    ) -> None:
        """Once round the object, steered by the intelligent space alone.

        Args:
            say: Told of progress.
            taken: Given all images.
        """
        follower, turned, told = PathFollower(), 0.0, 0.0
        last: float | None = None
        while self.robot.now < self.setup.seconds and turned < 2 * np.pi:
            fix = self._look(taken)
            if fix.T_map_base is None:
                self.robot.stop()
            else:
                azimuth = self._azimuth(fix.T_map_base)
                if last is not None:
                    turned += wrapped(azimuth - last)
                last = azimuth
                self.robot.drive(self._steered(follower, fix.T_map_base, azimuth))
            if self.robot.now >= told + TELL_EVERY:
                told = self.robot.now
                say(f"{told:.0f} s, {np.degrees(turned):.0f}° round the object, {fix.state}")
            self.robot.wait(1 / self.setup.rate)
        self.robot.stop()

    def _look(self, taken: Callable[[Sequence[CeilingImage]], None]) -> SpaceFix:
        """Images of now, and what the intelligent space makes of them."""
        truth = self.robot.truth()
        images = self.rig.images(truth)
        taken(images)
        began = time.perf_counter()
        fix = self.space.locate(images)
        self.milliseconds.append(1e3 * (time.perf_counter() - began))
        self.fixes.append(fix)
        self._truth.append((truth.stamp, truth.T_map_base))
        self._wheels.append((truth.stamp, self.robot.odometry().T_odom_base))
        return fix

    def _azimuth(self, pose: PlanarPose) -> float:
        x, y = pose.xy - self.place.orbit.centre_xy
        return float(np.arctan2(y, x))

    def _steered(self, follower: PathFollower, pose: PlanarPose, azimuth: float) -> Velocity:
        way = azimuth + np.linspace(0, AHEAD, 12)
        radius = self.place.orbit.radius + self.place.mount.left
        path = self.place.orbit.centre_xy + radius * np.column_stack([np.cos(way), np.sin(way)])
        goal = PlanarPose(float(path[-1, 0]), float(path[-1, 1]), float(way[-1] + np.pi / 2))
        return follower.velocity(pose, path, goal, self.setup.speed) or Velocity()

    @property
    def track(self) -> SpaceTrack:
        """What the intelligent space said so far."""
        return SpaceTrack.of(self.fixes, self.space.reports)

    @property
    def truth(self) -> Trajectory:
        """True poses of the base."""
        stamps, poses = zip(*self._truth, strict=True)
        return Trajectory(np.array(stamps), RigidTransform.concatenate(list(poses)))

    @property
    def odometry(self) -> Trajectory:
        """Poses of the base by its wheels alone, begun at the true first one."""
        stamps, poses = zip(*self._wheels, strict=True)
        start = PlanarPose.from_transform(self._truth[0][1]) @ poses[0].inverse()
        moved = [(start @ pose).as_transform() for pose in poses]
        return Trajectory(np.array(stamps), RigidTransform.concatenate(moved))

    @property
    def error(self) -> SpaceError | None:
        """Against the truth; None where the robot was never located."""
        try:
            return space_error(self.track, self.truth)
        except CircumspectError:
            return None

    def record(self) -> dict[str, Any]:
        """What came of it, JSON types."""
        error, rate = self.error, 1e3 / float(np.median(self.milliseconds))
        off = self.odometry.positions_xyz[-1] - self.truth.positions_xyz[-1]
        return {
            **self.track.summary(),
            "error": None if error is None else error.to_dict(),
            "odometry_end_m": float(np.linalg.norm(off[:2])),
            "milliseconds": float(np.median(self.milliseconds)),
            "rate_hz": rate,
            "setup": asdict(self.setup),
        }

    def save(self, run: LocatedRun) -> dict[str, Any]:
        """Write everything; what is told of it.

        Args:
            run: Made with `SIMULATED` as its further files.

        Raises:
            OutputError: A file can not be written.
        """
        write_calibration(run.path / CALIBRATION, self.calibration)
        write_tum(run.path / TRUTH, self.truth)
        write_tum(run.path / ODOMETRY, self.odometry)
        surface = next(s for s in self.place.scene.surfaces if s.name == "object")
        return run.save(
            self.track,
            self.calibration,
            self.rig.mount,
            {"odometry alone": self.odometry},
            self.record(),
            truth=self.truth,
            walls_xy=outlines(self.place.scene),
            object_xy=surface.mesh.vertices_xyz,
        )
