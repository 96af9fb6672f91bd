"""Whether errors are compared rightly with what was told of them."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.calibration import (
    Squares,
    along_the_axes,
    by_information,
    likeliest,
    of_edges,
    of_fits,
    of_steps,
    steps,
    tracked,
)
from benchmarks.calibration_job import CalibrationJob, run_job
from benchmarks.scan_job import ScanJob

from circumspect.mapping.keyframe_pairs import TOO_SURE, TRACKED_SIGMAS, blurred
from circumspect.registration.point_to_plane import FINE

COUNT = 4000


def drawn(factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Errors as the rule has them, times a factor, and the information H of scenes."""
    rng = np.random.default_rng(3)
    roots = rng.normal(size=(COUNT, 6, 6)) * ([1500.0] * 3 + [700.0] * 3)
    H = np.einsum("nij,nik->njk", roots, roots)
    covariances = np.linalg.inv(blurred(H / TOO_SURE**2, tracked()))
    noise = np.linalg.cholesky(covariances) @ rng.normal(size=(COUNT, 6, 1))
    return factor * noise[..., 0], H


def record(errors: np.ndarray, H: np.ndarray) -> dict:
    triangles = H[:, *np.triu_indices(6)]
    return {"object": "chair-1", "steps": np.hstack([errors, triangles]).tolist()}


def test_errors_as_they_are_told_have_the_mean_6() -> None:
    errors, H = drawn()
    squares = Squares.of(by_information(errors, blurred(H / TOO_SURE**2, tracked())))
    assert squares.mean == pytest.approx(6, rel=0.03)
    assert squares.median == pytest.approx(5.35, rel=0.03)
    assert squares.beyond == pytest.approx(0.01, abs=0.005)


@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_the_likeliest_rule_is_the_one_that_errors_were_drawn_by(factor: float) -> None:
    found = likeliest(*drawn(factor))
    rule = np.array([TRACKED_SIGMAS[0], TRACKED_SIGMAS[3], TOO_SURE])
    assert found == pytest.approx(factor * rule, rel=0.1)


def test_a_place_is_told_along_the_axes_of_its_own_information() -> None:
    tilt = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    H = np.eye(6)[None] * 1e8
    H[0, 3:, 3:] = tilt @ np.diag([0.01**-2, 0.004**-2, 0.001**-2]) @ tilt.T
    error = np.concatenate([np.zeros(3), 0.005 * tilt[:, 0]])[None]
    told, off = along_the_axes(error, H)
    assert told == pytest.approx([1, 4, 10], rel=1e-6)
    assert np.abs(off) == pytest.approx([0, 0, 5], abs=1e-9)


def test_steps_are_read_as_they_were_written() -> None:
    errors, H = drawn()
    again, H_again = steps([record(errors[:7], H[:7]), record(errors[7:9], H[7:9])])
    assert again == pytest.approx(errors[:9])
    assert H_again == pytest.approx(H[:9])


def test_edges_are_counted_by_kind_and_by_turn() -> None:
    edges = [[1, 0.2, 6], [0, np.radians(10), 1], [0, np.radians(20), 30], [0, np.radians(25), 2]]
    lines = of_edges([{"edges": edges}])[0].splitlines()
    assert lines[-3:] == [
        "| one keyframe and the next | 1 | 6.0 | 6.0 | 0.0% |",
        "| others, 0 to 15° apart | 1 | 1.0 | 1.0 | 0.0% |",
        "| others, 15 to 30° apart | 2 | 16.0 | 16.0 | 50.0% |",
    ]


def test_fits_are_told_object_by_object_and_together() -> None:
    found = [{"object": "night_stand-1", "fits": [[6, 6], [6, 6]]},
             {"object": "chair-1", "fits": [[12, 12]]}]  # fmt: skip
    lines = of_fits(found)[0].splitlines()
    by_median = f"{FINE.correlation * 6 / 5.35:.1f}"
    one, both = f"{FINE.correlation:.1f}", f"{FINE.correlation * 8 / 6:.1f}"
    assert lines[-3] == f"| night stand | 2 | 6.0 | 6.0 | 0.0% | {one} | {by_median} |"
    assert lines[-1] == f"| all | 3 | 8.0 | 6.0 | 0.0% | {both} | {by_median} |"


def test_a_scan_gives_what_the_tables_are_made_of() -> None:
    job = CalibrationJob(ScanJob("calibration", "chair-1", 0.0, 1, frame_interval=2.0, frames=20))
    found = run_job(job)
    assert found["key"] == job.key
    # Every eighth of the frames makes the map.
    assert np.array(found["fits"]).shape == (17, 2)
    errors, _ = steps([found])
    assert len(errors) >= 3
    assert np.abs(errors[:, 3:]).max() < 0.02
    assert len(found["edges"]) >= len(errors) - 1
    assert of_fits([found])[1]["all"]["number"] == 17
    assert of_steps([found])[1]["number"] == len(errors)
    told = sum(squares["number"] for squares in of_edges([found])[1].values())
    assert told == len(found["edges"])
