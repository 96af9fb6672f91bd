from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from small_world import blind, frames, make_pipeline

from circumspect.geometry import wrapped
from circumspect.grid import CylindricalGrid, OccupancyGrid
from circumspect.recognition.object_grids import azimuth_coverage

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
    assert azimuth_coverage(views(*bearings), GRID) == pytest.approx(share, abs=0.02)


def by_definition(views_xyz: np.ndarray, centre_xy: tuple[float, float]) -> float:
    """Every view is compared with every direction."""
    offset = views_xyz[:, :2] - np.array(centre_xy)
    bearings = np.arctan2(offset[:, 1], offset[:, 0])
    sectors = np.radians(2.5 + 5.0 * np.arange(72))
    apart = np.abs(wrapped(sectors[:, None] - bearings[None, :]))
    return float((apart <= np.radians(45.0)).any(axis=1).mean())


metres = st.floats(-4, 4, allow_subnormal=False)


@given(arrays(float, st.tuples(st.integers(0, 9), st.just(3)), elements=metres), metres, metres)
def test_coverage_equals_its_definition_for_any_axis(
    views_xyz: np.ndarray, x: float, y: float
) -> None:
    grid = OccupancyGrid(CylindricalGrid(centre_xyz=(x, y, 0.5)), GRID.states)
    assert azimuth_coverage(views_xyz, grid) == by_definition(views_xyz, (x, y))


def test_coverage_of_thousands_of_views_is_fast() -> None:
    many = np.random.default_rng(0).normal(0, 2, (36_000, 3))
    grown = [azimuth_coverage(many[:40], GRID)]
    start = time.process_time()
    grown.append(azimuth_coverage(many, GRID))
    assert time.process_time() - start < 0.05, "the table of all views and directions took 0.2 s"
    assert grown[1] == 1.0


def test_coverage_is_computed_once_per_changed_frame_and_timed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    counts = []

    def slow(views_xyz: np.ndarray, grid: OccupancyGrid) -> float:
        counts.append(len(views_xyz))
        time.sleep(0.02)
        return azimuth_coverage(views_xyz, grid)

    monkeypatch.setattr("circumspect.recognition.object_grids.azimuth_coverage", slow)
    shots = list(frames(4))
    pipeline = make_pipeline()
    steps = [
        pipeline.step(blind(shot) if number == 2 else shot) for number, shot in enumerate(shots)
    ]
    assert counts == [1, 2, 3], "a frame that changes nothing costs nothing"
    for step in steps:
        assert step.coverage == azimuth_coverage(step.model.views_xyz, step.grid)
        assert sum(step.milliseconds.values()) >= (0 if step.index == 2 else 20)
