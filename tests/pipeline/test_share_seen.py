from __future__ import annotations

import numpy as np
import pytest

from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.pipeline.views import share_seen

GRID = OccupancyGrid(CylindricalGrid(centre_xyz=(1.0, -2.0, 0.5)), np.zeros((32, 32, 32), np.uint8))


def views(*bearings_deg: float) -> np.ndarray:
    angles = np.radians(bearings_deg)
    return np.column_stack([1 + 2 * np.cos(angles), -2 + 2 * np.sin(angles), np.ones(len(angles))])


@pytest.mark.parametrize(
    ("bearings", "share"),
    [
        ((), 0.0), ((10,), 0.25), ((10, 10), 0.25), ((0, 90), 0.5), ((350, 10), 110 / 360),
        ((0, 180), 0.5), ((0, 90, 180, 270), 1.0),
    ],
)  # fmt: skip
def test_a_view_shows_a_quarter_and_views_overlap(
    bearings: tuple[float, ...], share: float
) -> None:
    assert share_seen(views(*bearings), GRID) == pytest.approx(share, abs=0.02)
