"""A driver for a robot of your own: one class, and the scan runs on it.

python examples/05_own_robot.py [FRAMES]    # needs: pip install "circumspect[sim]"
"""

import sys

import circumspect as cs
from circumspect.geometry import PlanarPose
from circumspect.mapping import RegisteredPoses
from circumspect.pipeline import ObjectScan, ScanSettings
from circumspect.planning import CirclePlanner
from circumspect.robot import MobileRobot, Velocity, arc
from circumspect.sensing import GroundSegmentation, Odometry
from circumspect.simulation import SimulatedCamera, Station, room


class MyRobot(MobileRobot):
    """Where this toy adds up arcs, ask your base's driver."""

    max_forward, max_turn = 0.5, 1.0  # what `drive` takes [m/s], [rad/s]
    radius = 0.25  # of the footprint [m]
    now = 0.0  # time [s]; yours is a property that reads a clock
    camera = T_base_camera = None  # set below; the mount is that of the optical frame

    def __init__(self, place) -> None:
        # Yours is an RgbdCamera: `intrinsics`, and `capture()` that returns an RgbdFrame.
        self.camera = SimulatedCamera(place.scene, self._station, tell_pose=False)
        self.T_base_camera = place.mount.T_base_camera
        self.T_map_start, self.T_start_base = place.start(40.0), PlanarPose()
        self.velocity = Velocity()

    def odometry(self) -> Odometry:
        return Odometry(self.now, self.T_start_base)

    def drive(self, velocity: Velocity) -> None:
        self.velocity = velocity.clipped(self.max_forward, self.max_turn)

    def wait(self, seconds: float) -> None:  # yours sleeps
        step = arc(self.velocity.forward * seconds, self.velocity.turn * seconds)
        self.T_start_base, self.now = self.T_start_base @ step, self.now + seconds

    def _station(self) -> Station:
        T_map_base = (self.T_map_start @ self.T_start_base).as_transform()
        return Station(self.now, T_map_base * self.T_base_camera)


if __name__ == "__main__":
    robot = MyRobot(room(cs.make_furniture("sofa", 1), seed=3))
    pipeline = cs.RecognitionPipeline(GroundSegmentation(), RegisteredPoses(), cs.Classifier.load())
    frames = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    settings = ScanSettings(speed=0.2, most_frames=frames)
    scan = ObjectScan(robot, pipeline, CirclePlanner(), settings)
    prediction = scan.run().prediction
    print(f"{scan.ended}: {prediction.label if prediction else 'nothing seen'}")
