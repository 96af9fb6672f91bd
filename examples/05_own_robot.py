"""A driver for a robot of your own: one class, and the scan runs on it.

python examples/05_own_robot.py [FRAMES]    # needs: pip install "circumspect[sim]"
"""

import sys

from scipy.spatial.transform import RigidTransform

import circumspect as cs
from circumspect.robot import arc
from circumspect.simulation import Room, SimulatedCamera, Station


class MyRobot(cs.MobileRobot):
    """Where this toy adds up arcs, ask your base's driver."""

    def __init__(self, place: Room) -> None:
        self._eye = SimulatedCamera(place.scene, self._station, with_pose=False)
        self._T_base_camera = place.mount.T_base_camera
        self._T_map_start, self._T_start_base = place.start(40.0), cs.PlanarPose()
        self._velocity, self._time = cs.Velocity(), 0.0

    @property
    def camera(self) -> SimulatedCamera:  # yours has `intrinsics`, and `capture()` of an RgbdFrame
        return self._eye

    @property
    def T_base_camera(self) -> RigidTransform:  # the mount, of the optical frame
        return self._T_base_camera

    @property
    def radius(self) -> float:  # of the footprint [m]
        return 0.25

    @property
    def max_forward(self) -> float:  # what `drive` takes [m/s]
        return 0.5

    @property
    def max_turn(self) -> float:  # what `drive` takes [rad/s]
        return 1.0

    @property
    def now(self) -> float:  # yours reads a clock [s]
        return self._time

    def odometry(self) -> cs.Odometry:
        return cs.Odometry(self.now, self._T_start_base)

    def drive(self, velocity: cs.Velocity) -> None:
        self._velocity = velocity.clipped(self.max_forward, self.max_turn)

    def wait(self, seconds: float) -> None:  # yours sleeps
        step = arc(self._velocity.forward * seconds, self._velocity.turn * seconds)
        self._T_start_base, self._time = self._T_start_base @ step, self._time + seconds

    def _station(self) -> Station:
        T_map_base = (self._T_map_start @ self._T_start_base).as_transform()
        return Station(self.now, T_map_base * self.T_base_camera)


if __name__ == "__main__":
    robot = MyRobot(cs.room(cs.make_furniture("sofa", 1), seed=3))
    pipeline = cs.RecognitionPipeline(cs.GroundSegmentation(), cs.Tracker(), cs.Classifier.load())
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    settings = cs.ScanSettings(speed=0.2, max_frames=frames)
    scan = cs.ObjectScan(robot, pipeline, cs.CirclePlanner(), settings)
    prediction = scan.run().prediction
    print(f"{scan.ended}: {prediction.label if prediction else 'nothing seen'}")
