from __future__ import annotations

import numpy as np
import pytest

from circumspect.errors import InputError
from circumspect.simulation.wheel_slip import WheelSlip


def lost_on_patches(slip: WheelSlip, wheel: int, count: int) -> np.ndarray:
    shares = []
    for _ in range(count):
        shares.append(slip.lost(wheel))
        slip.roll(wheel, 1.001 * WheelSlip.PATCH)
    return np.array(shares)


def test_the_mean_share_is_lost_and_it_varies() -> None:
    shares = lost_on_patches(WheelSlip(0.05, 0), 0, 4000)
    assert shares.mean() == pytest.approx(0.05, rel=0.05)
    assert shares.std() == pytest.approx(0.05, rel=0.1)
    assert shares.min() >= 0


def test_a_wheel_that_stands_stays_on_its_patch() -> None:
    slip = WheelSlip(0.1, 1)
    assert slip.lost(1) == slip.lost(1)
    slip.roll(1, 0.3 * WheelSlip.PATCH)
    assert slip.lost(1) == WheelSlip(0.1, 1).lost(1)


def test_the_way_of_one_wheel_does_not_change_the_floor_of_the_other() -> None:
    alone, both = WheelSlip(0.1, 2), WheelSlip(0.1, 2)
    lost_on_patches(both, 0, 7)
    np.testing.assert_array_equal(lost_on_patches(alone, 1, 9), lost_on_patches(both, 1, 9))
    assert not np.array_equal(lost_on_patches(alone, 0, 9), lost_on_patches(alone, 1, 9))


def test_a_gripping_wheel_loses_nothing() -> None:
    assert lost_on_patches(WheelSlip(0.0, 3), 0, 20).max() == 0


def test_no_patch_takes_all() -> None:
    assert lost_on_patches(WheelSlip(0.5, 4), 0, 500).max() <= WheelSlip.WORST


@pytest.mark.parametrize("share", [-0.1, 0.6, np.nan])
def test_impossible_shares_are_refused(share: float) -> None:
    with pytest.raises(InputError, match="share"):
        WheelSlip(share)
