"""The trial of GTSAM compares equal problems."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.gtsam_trial import by_gtsam, drive, graph, smoothed, smoothed_by_gtsam

from circumspect.geometry.composition import distances


def test_the_graph_is_far_from_its_optimum_and_has_wrong_loops() -> None:
    asked = graph(60)
    found = asked.optimised()
    assert found.cost < 0.5 * asked.cost
    errors = np.array([factor.T_first_second.translation for factor in asked.between_factors])
    assert np.abs(errors).max() < 4.0


def test_the_window_follows_the_measured_poses() -> None:
    rows = drive()
    last, milliseconds = smoothed(rows)
    assert distances(last, rows[-1][1])[0] < 0.01
    assert milliseconds > 0


def test_both_find_the_same_optimum() -> None:
    pytest.importorskip("gtsam", reason="GTSAM is not installed: pip install gtsam==4.3.0")
    asked = graph(30)
    ours = np.stack([pose.as_matrix() for pose in asked.optimised().poses])
    assert distances(ours, by_gtsam(asked))[0].max() < 1e-4
    apart, _ = distances(smoothed(drive())[0], smoothed_by_gtsam(drive())[0])
    assert apart < 0.005
