"""Coarse alignment by generalised ICP."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import SHORT, short_drive, true_camera

from circumspect.errors import InputError
from circumspect.geometry import se3
from circumspect.mapping.relocalisation import coarsely_aligned
from circumspect.registration import Scan


def test_coarse_alignment_has_a_larger_range() -> None:
    true, scan = true_camera(float(SHORT[0])), Scan.from_frame(short_drive()[0])
    off = se3.exp([0.0, 0.0, 0.08, 0.08, 0.05, 0.0])
    found = coarsely_aligned(scan.points_xyz, true.apply(scan.points_xyz), true * off)
    assert np.linalg.norm((true.inv() * found).translation) < 0.02


@pytest.mark.parametrize("points", [np.zeros(3), np.zeros((5, 2)), np.full((5, 3), np.nan)])
def test_points_that_small_gicp_would_misread_are_refused(points: np.ndarray) -> None:
    with pytest.raises(InputError, match="source points must be finite with shape"):
        coarsely_aligned(points, np.ones((9, 3)), RigidTransform.identity())
