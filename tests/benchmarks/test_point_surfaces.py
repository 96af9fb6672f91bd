"""Reconstructed surfaces are compared with true ones."""

import numpy as np
import pytest
from benchmarks.point_surfaces import differences, page_text

FAR = np.inf


def test_rays_through_beside_and_before_the_surface_are_counted_separately():
    true = np.array([1.0, 1.0, 1.0, 1.0, 1.0, FAR])
    rebuilt = np.array([1.002, 1.2, FAR, 0.9, 0.996, 2.0])
    through, missed, before, median, most = differences(true, rebuilt)
    assert (through, missed, before) == pytest.approx((0.4, 0.2, 0.4))
    assert median == pytest.approx(52)
    assert 52 < most <= 200


def test_a_surface_has_no_difference_from_itself():
    depth = np.array([[1.0, FAR], [2.0, 1.5]])
    assert differences(depth, depth) == pytest.approx([0, 0, 0, 0, 0])


def test_the_table_ends_with_the_mean():
    lines = page_text({"night_stand": [0.1, 0.0, 0.2, 1.0, 2.0], "bed": [0.3, 0.0, 0.0, 3.0, 4.0]})
    rows = [line for line in lines.splitlines() if line.startswith("| ")]
    assert rows[2].startswith("| night stand | 10.0% |")
    assert rows[-1] == "| mean | 20.0% | 0.0% | 10.0% | 2.0 | 3.0 |"
