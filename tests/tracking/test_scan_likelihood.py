"""How well a scan fits the map: support, violations, overlap."""

from __future__ import annotations

import numpy as np
import pytest
from tracking_world import SETTINGS, drive, follow, true_camera

from circumspect.registration import Scan
from circumspect.tracking import Tracker
from circumspect.tracking.scan_likelihood import ScanLikelihood, scan_likelihood


@pytest.mark.parametrize(("overlap", "found"), [(0.49, False), (0.51, True)])
def test_a_lost_camera_is_found_by_scans_of_the_map_not_of_unknown_space(
    overlap: float, found: bool
) -> None:
    likelihood = ScanLikelihood(300.0, 0.0, overlap)
    assert likelihood.confirms
    assert likelihood.recognises is found
    assert not ScanLikelihood(300.0, -100.0, 1.0).recognises


@pytest.mark.parametrize(("angle_deg", "low", "high"), [(20.0, 0.8, 1.0), (180.0, 0.0, 0.3)])
def test_the_overlap_is_the_share_of_mapped_points(
    angle_deg: float, low: float, high: float
) -> None:
    mapped = np.radians(np.arange(0, 45, 5.0))
    tracker = Tracker(true_camera(float(mapped[0])), SETTINGS)
    follow(drive(mapped), tracker)
    angle = float(np.radians(angle_deg))
    (frame,) = drive(np.array([angle]))
    scan, T = Scan.from_frame(frame, SETTINGS.scan), true_camera(angle).as_matrix()
    found = scan_likelihood(frame, scan, tracker.keyframes, T)
    assert low <= found.overlap <= high
    assert found.recognises is (angle_deg == 20.0)
