from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import InputError
from circumspect.simulation.robot_physics import WheelSlip


def lost_on_patches(slip: WheelSlip, wheel: int, count: int) -> np.ndarray:
    shares = []
    for _ in range(count):
        shares.append(slip.slip(wheel))
        slip.roll(wheel, 1.001 * WheelSlip.PATCH_M)
    return np.array(shares)


def test_slip_varies_around_its_mean() -> None:
    shares = lost_on_patches(WheelSlip(0.05, 0), 0, 4000)
    assert shares.mean() == pytest.approx(0.05, rel=0.05)
    assert shares.std() == pytest.approx(0.05, rel=0.1)
    assert shares.min() >= 0


def test_a_standing_wheel_keeps_its_slip() -> None:
    slip = WheelSlip(0.1, 1)
    assert slip.slip(1) == slip.slip(1)
    slip.roll(1, 0.3 * WheelSlip.PATCH_M)
    assert slip.slip(1) == WheelSlip(0.1, 1).slip(1)


def test_the_slip_of_one_wheel_is_independent_of_the_other() -> None:
    alone, both = WheelSlip(0.1, 2), WheelSlip(0.1, 2)
    lost_on_patches(both, 0, 7)
    np.testing.assert_array_equal(lost_on_patches(alone, 1, 9), lost_on_patches(both, 1, 9))
    assert not np.array_equal(lost_on_patches(alone, 0, 9), lost_on_patches(alone, 1, 9))


def test_without_slip_no_distance_is_lost() -> None:
    assert lost_on_patches(WheelSlip(0.0, 3), 0, 20).max() == 0


def test_no_patch_takes_all() -> None:
    assert lost_on_patches(WheelSlip(0.5, 4), 0, 500).max() <= WheelSlip.MAX_SLIP


@pytest.mark.parametrize("share", [-0.1, 0.6, np.nan])
def test_impossible_shares_are_refused(share: float) -> None:
    with pytest.raises(InputError, match="slip"):
        WheelSlip(share)
