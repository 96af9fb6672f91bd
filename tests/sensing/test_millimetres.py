"""Depth in whole millimetres, there and back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from circumspect.sensing.millimetres import metres, millimetres


def test_every_value_round_trips() -> None:
    every = np.arange(65536, dtype=np.uint16)
    back = millimetres(metres(every))
    np.testing.assert_array_equal(back[:-1], every[:-1])
    assert back[-1] == 0, "65535 is invalid as well, and written as 0"
    assert np.isnan(metres(every)[[0, -1]]).all()


@given(st.floats(0.125, 65.0, width=32))
@example(6.275500297546387)  # all but half way between two millimetres
def test_the_nearest_depth_is_kept(depth: float) -> None:
    kept = metres(millimetres(np.array([depth], np.float32)))
    # Half a millimetre, as far as 32 bits resolve depths: 15 nm at 0.125 m, 8 µm at 65 m.
    assert abs(float(kept[0]) - depth) <= 0.5e-3 + 2 * float(np.spacing(np.float32(depth)))
    np.testing.assert_array_equal(metres(millimetres(kept)), kept, "nothing is lost twice")


@pytest.mark.parametrize("depth", [np.nan, np.inf, -np.inf, -1.0, 0.0, 0.0004, 65.6, 1e30])
def test_depths_beyond_16_bits_are_invalid(depth: float) -> None:
    assert millimetres(np.array([depth], np.float32))[0] == 0
