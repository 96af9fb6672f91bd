"""Consistency of registrations and factors with their errors: `python -m benchmarks.calibration`.

Information matrices weight scans, motions and keyframes. They are compared with the true errors in
scans of furniture, one for each category, with variants and starts that no other table uses.
`docs/derivations.md` explains the constants.

Each scan is one JSON line in `benchmarks/results/calibration.jsonl` and is not repeated.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.calibration_job import PRIOR_SIGMAS, CalibrationJob, run_job
from benchmarks.report import RESULTS, progress_report, write_page
from benchmarks.scan_job import ScanJob
from benchmarks.selection import records_of_jobs
from circumspect.evaluation.markdown import table
from circumspect.furniture import CATEGORIES
from circumspect.gathering.job_pool import LocalPool, records, run_all
from circumspect.registration.scan import WHITE_CORRELATION

COMMAND = "python -m benchmarks.calibration"
FIRST_VARIANT = 300_000
"""First variant of the furniture; no other benchmark uses these variants."""
SIGMAS_MM = (0.0, 0.5, 1.0, 2.0, 4.0, 1e3)
"""Bin edges of the predicted standard deviation [mm]."""
ANGLES_DEG = (0.0, 15.0, 30.0, 60.0, 180.0)
"""Bin edges of the angle between two views [degrees]."""
CHI2_99 = 16.81
"""99th percentile of χ² with six degrees of freedom."""
CHI2_MEDIAN = 5.35
"""Median of χ² with six degrees of freedom."""
MEDIAN_TO_SIGMA = 1.4826
"""Standard deviation of a normal distribution, in medians of the absolute error."""


def main() -> int:
    """Run missing scans and write `calibration.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--tables", action="store_true", help="only write the tables")
    given = parser.parse_args()
    path: Path = given.out / "calibration.jsonl"
    if not given.tables:
        run_all(jobs(), run_job, path, LocalPool(given.workers), progress_report())
    found = records_of_jobs(records(path), jobs())
    parts = {"fits": of_fits(found)}
    # Older records contain other figures of keyframes.
    if with_factors := [record for record in found if "tracking" in record]:
        parts |= {"tracking": of_tracking(with_factors), "pairs": of_pairs(with_factors)}
    text = "\n\n".join(part for part, _ in parts.values())
    measured = {name: figures for name, (_, figures) in parts.items()}
    title = "Consistency of registrations and factors"
    write_page("calibration", title, COMMAND, text, measured, given.out)
    return 0


def jobs() -> list[CalibrationJob]:
    """One scan of each category, each from its own start."""
    rng = np.random.default_rng(FIRST_VARIANT)
    return [
        CalibrationJob(
            ScanJob(
                "calibration",
                f"{category}-{FIRST_VARIANT}",
                float(np.round(start, 1)),
                int(seed),
                shape=False,
            )
        )
        for category, start, seed in zip(
            CATEGORIES,
            rng.uniform(0, 360, len(CATEGORIES)),
            rng.integers(2**31, size=len(CATEGORIES)),
            strict=True,
        )
    ]


class Squares(NamedTuple):
    """Statistics of normalised squared errors eᵀΩe.

    Attributes:
        number: Number of errors.
        mean: Mean; 6 if Ω is consistent with the errors.
        median: Median; `CHI2_MEDIAN` if consistent.
        beyond: Share beyond `CHI2_99`; 1 % if consistent.
    """

    number: int
    mean: float
    median: float
    beyond: float

    @classmethod
    def of(cls, squared: NDArray[np.float64]) -> Squares:
        """The statistics of at least one value."""
        return cls(
            len(squared),
            float(squared.mean()),
            float(np.median(squared)),
            float((squared > CHI2_99).mean()),
        )

    @property
    def cells(self) -> list[str]:
        """Cells of a table row."""
        return [str(self.number), f"{self.mean:.1f}", f"{self.median:.1f}", f"{self.beyond:.1%}"]


SQUARES = ["count", "mean", "median", f"beyond {CHI2_99:.1f}"]


def of_fits(found: Sequence[dict[str, Any]]) -> tuple[str, Any]:
    """Consistency of `Registration.information`, and the consistent `WHITE_CORRELATION`."""
    fits = {record["object"].rsplit("-", 1)[0]: np.array(record["fits"]) for record in found}
    rows, figures, used = [], {}, WHITE_CORRELATION
    for name, values in {**fits, "all": np.concatenate(list(fits.values()))}.items():
        squares, scan_only = Squares.of(values[:, 0]), Squares.of(values[:, 1])
        off = {"mean": scan_only.mean / 6, "median": scan_only.median / CHI2_MEDIAN}
        by = {rule: used * times for rule, times in off.items()}
        figures[name] = {**squares._asdict(), "correlation_by": by}
        best = [f"{value:.1f}" for value in by.values()]
        rows.append([name.replace("_", " "), *squares.cells, *best])
    turn, shift = 1e3 * PRIOR_SIGMAS[0], 1e3 * PRIOR_SIGMAS[3]
    text = (
        "## A frame fitted to the map\n\n"
        "The map contains every eighth frame at its true pose. The frames between are registered "
        f"to it; the errors of their priors have a standard deviation of {turn:.0f} mrad and "
        f"{shift:.0f} mm for each axis. eᵀ(H + Λ)e of the error e has the mean 6 and the median "
        f"{CHI2_MEDIAN} if the information is consistent, and more if it is too large. The last "
        f"columns are the `WHITE_CORRELATION` ({used:g} in the code) that would give eᵀHe the mean "
        f"6 or the median {CHI2_MEDIAN}.\n\n"
        + table(["", *SQUARES, "by the mean", "by the median"], rows)
    )
    return text, figures


def of_tracking(found: Sequence[dict[str, Any]]) -> tuple[str, Any]:
    """Consistency of the factors from tracking."""
    errors, omega = tracked(found)
    expected, off = along_the_axes(errors, omega)
    rows = []
    for low, high in pairwise(SIGMAS_MM):
        there = (expected >= low) & (expected < high)
        if there.any():
            sigmas = [float(np.sqrt(np.mean(v[there] ** 2))) for v in (expected, off)]
            rows.append(
                [low, high, there.sum(), *sigmas, MEDIAN_TO_SIGMA * np.median(np.abs(off[there]))]
            )
    squares = Squares.of(by_information(errors, omega))
    head = ["by Ω [mm]", "axes", "by Ω, RMS", "error, RMS", f"{MEDIAN_TO_SIGMA} median \\|error\\|"]
    cells = [
        [f"{low:g} to {high:g}" if high < SIGMAS_MM[-1] else f"{low:g} on", str(number),
         *(f"{value:.2f}" for value in values)]
        for low, high, number, *values in rows
    ]  # fmt: skip
    text = (
        "## From one keyframe to the next\n\n"
        "Factors of tracking between a keyframe and its reference keyframe, with information Ω. "
        "The standard deviations of the position are those along its three principal axes [mm]. "
        "The last column is the root mean square of normal errors with the same median of the "
        "absolute error.\n\n"
        + table(head, cells)
        + "\n\neᵀΩe of the errors e of rotation and position:\n\n"
        + table(SQUARES, [squares.cells])
    )
    named = ("from_mm", "to_mm", "axes", "expected_mm", "error_mm", "by_median_mm")
    return text, {
        "axes": [dict(zip(named, map(float, row), strict=True)) for row in rows],
        **squares._asdict(),
    }


def of_pairs(found: Sequence[dict[str, Any]]) -> tuple[str, Any]:
    """Consistency of registered pairs of keyframes, by the angle between their views."""
    pairs = np.concatenate([np.array(record["pairs"]).reshape(-1, 2) for record in found])
    angles = np.degrees(pairs[:, 0])
    kinds = {
        f"{low:g} to {high:g}° apart": (angles >= low) & (angles < high)
        for low, high in pairwise(ANGLES_DEG)
    }
    counted = {name: Squares.of(pairs[there, 1]) for name, there in kinds.items() if there.any()}
    rows = [[name, *squares.cells] for name, squares in counted.items()]
    text = (
        "## Keyframes registered to each other\n\n"
        "eᵀΩe of the factors of the pose graph when the scan has ended.\n\n"
        + table(["views", *SQUARES], rows)
    )
    return text, {name: squares._asdict() for name, squares in counted.items()}


def tracked(
    found: Sequence[dict[str, Any]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, 6) errors and (n, 6, 6) information of the factors from tracking of all scans."""
    lines = np.concatenate([np.array(record["tracking"]).reshape(-1, 27) for record in found])
    omega = np.zeros((len(lines), 6, 6))
    rows, columns = np.triu_indices(6)
    omega[:, rows, columns] = omega[:, columns, rows] = lines[:, 6:]
    return lines[:, :6], omega


def along_the_axes(
    errors: NDArray[np.float64], omega: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(3n,) standard deviations of positions along their principal axes [mm], and the errors."""
    variances, axes = np.linalg.eigh(np.linalg.inv(omega)[:, 3:, 3:])
    off = np.einsum("nij,ni->nj", axes, errors[:, 3:])
    return 1e3 * np.sqrt(variances).ravel(), 1e3 * off.ravel()


def by_information(errors: NDArray[np.float64], omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) eᵀΩe of (n, 6) errors and (n, 6, 6) information."""
    return np.einsum("ni,nij,nj->n", errors, omega, errors)


if __name__ == "__main__":
    sys.exit(main())
