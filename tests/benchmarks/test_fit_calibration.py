"""Errors are compared with the information of measurements."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.calibration import (
    Squares,
    along_the_axes,
    by_information,
    of_fits,
    of_pairs,
    of_tracking,
    tracked,
)
from benchmarks.calibration_job import CalibrationJob, Measured, run_job
from benchmarks.scan_job import ScanJob

from circumspect.registration.scan import WHITE_CORRELATION

COUNT = 4000


def drawn(factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Errors drawn from their information Ω, times a factor."""
    rng = np.random.default_rng(3)
    roots = rng.normal(size=(COUNT, 12, 6)) * ([1500.0] * 3 + [700.0] * 3)
    omega = np.einsum("nij,nik->njk", roots, roots)
    noise = np.linalg.cholesky(np.linalg.inv(omega)) @ rng.normal(size=(COUNT, 6, 1))
    return factor * noise[..., 0], omega


def record(errors: np.ndarray, omega: np.ndarray) -> dict:
    rows = [Measured(*one).row for one in zip(errors, omega, strict=True)]
    return {"object": "chair-1", "tracking": rows}


def test_consistent_errors_have_the_mean_6() -> None:
    squares = Squares.of(by_information(*drawn()))
    assert squares.mean == pytest.approx(6, rel=0.03)
    assert squares.median == pytest.approx(5.35, rel=0.03)
    assert squares.beyond == pytest.approx(0.01, abs=0.005)


@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_errors_are_compared_with_their_standard_deviations(factor: float) -> None:
    figures = of_tracking([record(*drawn(factor))])[1]
    assert figures["number"] == COUNT
    assert figures["mean"] == pytest.approx(6 * factor**2, rel=0.03)
    largest = max(figures["axes"], key=lambda row: row["axes"])
    assert largest["error_mm"] == pytest.approx(factor * largest["expected_mm"], rel=0.05)
    assert largest["by_median_mm"] < factor * 1.1 * largest["expected_mm"]
    assert sum(row["axes"] for row in figures["axes"]) == 3 * COUNT


def test_a_position_is_taken_along_the_axes_of_its_own_information() -> None:
    tilt = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    omega = np.eye(6)[None] * 1e8
    omega[0, 3:, 3:] = tilt @ np.diag([0.01**-2, 0.004**-2, 0.001**-2]) @ tilt.T
    error = np.concatenate([np.zeros(3), 0.005 * tilt[:, 0]])[None]
    sigmas, off = along_the_axes(error, omega)
    assert sigmas == pytest.approx([1, 4, 10], rel=1e-6)
    assert np.abs(off) == pytest.approx([0, 0, 5], abs=1e-9)


def test_factors_are_read_as_they_were_written() -> None:
    errors, omega = drawn()
    again, omega_again = tracked([record(errors[:7], omega[:7]), record(errors[7:9], omega[7:9])])
    assert again == pytest.approx(errors[:9], rel=1e-4)
    assert omega_again == pytest.approx(omega[:9], rel=1e-4)


def test_pairs_are_counted_by_the_angle_between_their_views() -> None:
    pairs = [[np.radians(10), 1], [np.radians(20), 30], [np.radians(25), 2]]
    lines = of_pairs([{"pairs": pairs}, {"pairs": []}])[0].splitlines()
    assert lines[-2:] == [
        "| 0 to 15° apart | 1 | 1.0 | 1.0 | 0.0% |",
        "| 15 to 30° apart | 2 | 16.0 | 16.0 | 50.0% |",
    ]


def test_fits_are_counted_object_by_object_and_together() -> None:
    found = [{"object": "night_stand-1", "fits": [[6, 6], [6, 6]]},
             {"object": "chair-1", "fits": [[12, 12]]}]  # fmt: skip
    lines = of_fits(found)[0].splitlines()
    by_median = f"{WHITE_CORRELATION * 6 / 5.35:.1f}"
    one, both = f"{WHITE_CORRELATION:.1f}", f"{WHITE_CORRELATION * 8 / 6:.1f}"
    assert lines[-3] == f"| night stand | 2 | 6.0 | 6.0 | 0.0% | {one} | {by_median} |"
    assert lines[-1] == f"| all | 3 | 8.0 | 6.0 | 0.0% | {both} | {by_median} |"


def test_a_job_records_the_data_of_the_tables() -> None:
    job = CalibrationJob(ScanJob("calibration", "chair-1", 0.0, 1, frame_interval=2.0, frames=20))
    found = run_job(job)
    assert found["key"] == job.key
    # Every eighth of the frames makes the map.
    assert np.array(found["fits"]).shape == (17, 2)
    errors, _ = tracked([found])
    assert len(errors) >= 3
    assert np.abs(errors[:, 3:]).max() < 0.02
    assert len(found["pairs"]) >= 1
    assert of_fits([found])[1]["all"]["number"] == 17
    assert of_tracking([found])[1]["number"] == len(errors)
    pairs = sum(squares["number"] for squares in of_pairs([found])[1].values())
    assert pairs == len(found["pairs"])
