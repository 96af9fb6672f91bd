import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.sensing import Odometry, RgbdFrame


def test_the_covariance_is_kept_read_only():
    odometry = Odometry(1.0, PlanarPose(1, 2, 3), np.eye(3))
    assert not odometry.covariance.flags.writeable


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_covariance_that_is_not_finite_is_unknown(bad):
    covariance = np.eye(3)
    covariance[0, 1] = bad
    odometry = Odometry(1.0, PlanarPose(), covariance)
    np.testing.assert_array_equal(odometry.covariance, np.zeros((3, 3)))


@pytest.mark.parametrize("name", ["stamp", "forward", "turn"])
def test_a_value_that_is_not_finite_is_refused(name):
    values = {"stamp": 0.0, "T_odom_base": PlanarPose(), name: np.nan}
    with pytest.raises(InputError, match="finite"):
        Odometry(**values)


@pytest.mark.parametrize("covariance", [np.eye(2), np.arange(9.0).reshape(3, 3)])
def test_an_impossible_covariance_is_refused(covariance):
    with pytest.raises(InputError):
        Odometry(0.0, PlanarPose(), covariance)


POSES = st.builds(PlanarPose, *[st.floats(-3, 3)] * 3)
ROOTS = arrays(np.float64, (3, 3), elements=st.floats(-1, 1))


@given(POSES, POSES, ROOTS, ROOTS)
def test_growth_since_inverts_grown_from(before, now, old, new):
    first = Odometry(0.0, before, old @ old.T)
    then = Odometry(1.0, now).grown_from(first, new @ new.T)
    np.testing.assert_allclose(then.growth_since(first), new @ new.T, atol=1e-9)


def test_a_heading_error_becomes_a_lateral_error():
    first = Odometry(0.0, PlanarPose(1.0, 1.0, 0.5), np.diag([0.0, 0.0, 0.1**2]))
    then = Odometry(1.0, PlanarPose(1.0, 3.0, 2.0)).grown_from(first, np.zeros((3, 3)))
    np.testing.assert_allclose(np.sqrt(np.diag(then.covariance)), [0.2, 0.0, 0.1])


def test_growth_is_given_in_the_robot_frame():
    ahead = np.diag([0.3**2, 0.0, 0.0])
    then = Odometry(1.0, PlanarPose(0, 0, np.pi / 2)).grown_from(Odometry(0.0, PlanarPose()), ahead)
    np.testing.assert_allclose(then.covariance, np.diag([0.0, 0.3**2, 0.0]), atol=1e-12)


def test_a_stamp_must_be_finite():
    with pytest.raises(InputError, match="finite"):
        Odometry(np.nan, PlanarPose())


def test_a_moved_frame_keeps_its_odometry():
    camera = PinholeCamera(4, 3, 5, 5, 2, 1.5)
    odometry = Odometry(0.0, PlanarPose(1, 2, 3))
    mounted = PlanarPose(0, 0.2, 1).as_transform()
    frame = RgbdFrame(np.ones((3, 4)), camera, 0.0, odometry=odometry, T_base_camera=mounted)
    moved = frame.at(PlanarPose(4, 5, 6).as_transform())
    assert moved.odometry is odometry
    assert moved.T_base_camera is mounted


def test_a_rigid_transform_becomes_a_planar_pose():
    T = RigidTransform.from_components([1.0, 2.0, 0.3], Rotation.from_rotvec([0.0, 0.0, 0.5]))
    pose = Odometry(0.0, T).T_odom_base
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, 2.0, 0.5))


@pytest.mark.parametrize(
    "pose", [np.eye(4), (1.0, 2.0, 0.5), None, RigidTransform.identity(1)], ids=str
)
def test_any_other_pose_is_refused(pose):
    with pytest.raises(InputError, match=r"PlanarPose\(x, y, yaw\) or one RigidTransform"):
        Odometry(0.0, pose)


@pytest.mark.parametrize("shape", [(6, 6), (36,)])
def test_a_6x6_covariance_of_ros_is_refused(shape):
    with pytest.raises(InputError, match="rows and columns 0, 1 and 5"):
        Odometry(0.0, PlanarPose(), np.eye(6).reshape(shape))


def test_a_frame_takes_odometry_and_transforms_only():
    camera = PinholeCamera(4, 3, 5, 5, 2, 1.5)
    for name in ("T_map_camera", "T_base_camera"):
        with pytest.raises(InputError, match=rf"{name} must be a SciPy RigidTransform"):
            RgbdFrame(np.ones((3, 4)), camera, 0.0, **{name: np.eye(4)})
    with pytest.raises(InputError, match="T_map_camera must be a SciPy RigidTransform"):
        RgbdFrame(np.ones((3, 4)), camera, 0.0).at(np.eye(4))
    with pytest.raises(InputError, match=r"odometry must be an Odometry, not PlanarPose"):
        RgbdFrame(np.ones((3, 4)), camera, 0.0, odometry=PlanarPose())
    with pytest.raises(InputError, match=r"camera must be a PinholeCamera, not list"):
        RgbdFrame(np.ones((3, 4)), [4, 3, 5, 5, 2, 1.5], 0.0)
