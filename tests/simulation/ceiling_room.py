"""Three cameras below a ceiling, and the robot that they look at."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.localization import FixedCamera, LensCamera, TagMount
from circumspect.simulation import CeilingOptics, CeilingRig, Scene, TrueState, block

MOUNT = TagMount(3, 0.20, 0.30, PlanarPose(0.02, 0.01, 0.3))
SIZE = (640, 480)
FAR = block((3.0, 3.0, 0.0), (3.2, 3.2, 0.1))
ASIDE = RigidTransform.from_components([0.04, 0.0, 0.0], Rotation.identity())


def hung(x=0.0, y=0.0, name="a", heading=20.0):
    bend = (-0.15, 0.03, 3e-4, -2e-4, 0.0)
    lens = LensCamera(PinholeCamera(*SIZE, 430.0, 431.0, 322.0, 237.0), bend)
    turn = Rotation.from_euler("z", heading, degrees=True) * Rotation.from_euler(
        "x", 178, degrees=True
    )
    return FixedCamera(name, lens, RigidTransform.from_components([x, y, 3.0], turn))


def truth(x=0.0, y=0.0, yaw=0.0, stamp=0.0):
    pose = PlanarPose(x, y, yaw).as_transform()
    return TrueState(stamp, pose, pose)


def three_cameras():
    return (hung(-0.4, 0.0, "a"), hung(0.5, 0.1, "b", -60.0), hung(0.0, 0.3, "c", 100.0))


def still_rig(cameras):
    """A rig without motion blur: the robot jumps between images."""
    return CeilingRig(cameras, Scene.with_object(FAR), MOUNT, CeilingOptics(exposure=0.0), seed=4)
