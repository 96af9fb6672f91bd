import numpy as np
import pytest

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.sensing import Odometry, RgbdFrame


def test_the_covariance_is_kept_read_only():
    odometry = Odometry(1.0, PlanarPose(1, 2, 3), np.eye(3))
    assert not odometry.covariance.flags.writeable


@pytest.mark.parametrize(
    "covariance", [np.eye(2), np.arange(9.0).reshape(3, 3), np.full((3, 3), np.nan)]
)
def test_an_impossible_covariance_is_refused(covariance):
    with pytest.raises(InputError):
        Odometry(0.0, PlanarPose(), covariance)


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
