"""Whether fits err by what they tell: `python -m benchmarks.calibration`.

The fusion weighs scan, prediction and keyframes by the information that each tells of itself. Over
scans of furniture, one a category, of variants and starts that no other table is of, that is
compared with the truth. `docs/derivations.md` says what the constants mean.

Every scan is one JSON line in `benchmarks/results/calibration.jsonl`; what is there is not done
again.
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
from scipy.optimize import minimize

from benchmarks.asked import of_jobs
from benchmarks.calibration_job import PRIOR_SIGMAS, CalibrationJob, run_job
from benchmarks.report import RESULTS, telling, write_page
from benchmarks.scan_job import ScanJob
from circumspect.evaluation.markdown import table
from circumspect.furniture import CATEGORIES
from circumspect.gathering.job_pool import records, run_all
from circumspect.mapping.keyframe_pairs import TOO_SURE, TRACKED_SIGMAS, blurred
from circumspect.registration.scan import WHITE_CORRELATION

COMMAND = "python -m benchmarks.calibration"
FIRST_VARIANT = 300_000
"""Of the furniture: variants that nothing else uses."""
TOLD_MM = (0.0, 0.5, 1.0, 2.0, 4.0, 1e3)
"""Between these standard deviations errors are counted together."""
TURNS_DEG = (0.0, 15.0, 30.0, 60.0, 180.0)
SELDOM = 16.81
"""χ² of six degrees of freedom is beyond this once in a hundred times."""
MIDDLE = 5.35
"""Its median."""
NORMAL = 1.4826
"""So many times the median of what is normal is its standard deviation."""


def main() -> int:
    """Scan what is not done yet, and write `calibration.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--tables", action="store_true", help="scan nothing")
    given = parser.parse_args()
    path: Path = given.out / "calibration.jsonl"
    if not given.tables:
        run_all(jobs(), run_job, path, given.workers, telling())
    found = of_jobs(records(path), jobs())
    parts = {"fits": of_fits(found), "steps": of_steps(found), "edges": of_edges(found)}
    text = "\n\n".join(part for part, _ in parts.values())
    measured = {name: figures for name, (_, figures) in parts.items()}
    write_page("calibration", "What fits tell and err by", COMMAND, text, measured, given.out)
    return 0


def jobs() -> list[CalibrationJob]:
    """One scan of each category, from a start of its own."""
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
    """Errors by what was told of them, eᵀΩe.

    Attributes:
        number: Of the errors.
        mean: 6 where what is told is right.
        median: `MIDDLE` then.
        beyond: Share beyond `SELDOM`, a hundredth then.
    """

    number: int
    mean: float
    median: float
    beyond: float

    @classmethod
    def of(cls, squared: NDArray[np.float64]) -> Squares:
        """Counted; there is at least one."""
        return cls(
            len(squared),
            float(squared.mean()),
            float(np.median(squared)),
            float((squared > SELDOM).mean()),
        )

    @property
    def cells(self) -> list[str]:
        """Of a table."""
        return [str(self.number), f"{self.mean:.1f}", f"{self.median:.1f}", f"{self.beyond:.1%}"]


SQUARES = ["count", "mean", "median", f"beyond {SELDOM:.1f}"]


def of_fits(found: Sequence[dict[str, Any]]) -> tuple[str, Any]:
    """How right `Registration.information` is, and what `WHITE_CORRELATION` would make of it."""
    fits = {record["object"].rsplit("-", 1)[0]: np.array(record["fits"]) for record in found}
    rows, figures, used = [], {}, WHITE_CORRELATION
    for name, values in {**fits, "all": np.concatenate(list(fits.values()))}.items():
        squares, held = Squares.of(values[:, 0]), Squares.of(values[:, 1])
        off = {"mean": held.mean / 6, "median": held.median / MIDDLE}
        by = {rule: used * times for rule, times in off.items()}
        figures[name] = {**squares._asdict(), "correlation_by": by}
        best = [f"{value:.1f}" for value in by.values()]
        rows.append([name.replace("_", " "), *squares.cells, *best])
    turn, shift = 1e3 * PRIOR_SIGMAS[0], 1e3 * PRIOR_SIGMAS[3]
    text = (
        "## A frame fitted to the map\n\n"
        "Every eighth frame makes the map, at its true pose; those between are fitted to it from "
        f"poses that are {turn:.0f} mrad and {shift:.0f} mm off about each axis. eᵀ(H + Λ)e of the "
        f"error e, which has the mean 6 and the median {MIDDLE} where information is told rightly; "
        f"more is too sure. Beside it the `correlation`, {used:g} in the code, that would "
        f"make the mean of eᵀHe 6, and the one that would make its median {MIDDLE}.\n\n"
        + table(["", *SQUARES, "by the mean", "by the median"], rows)
    )
    return text, figures


def of_steps(found: Sequence[dict[str, Any]]) -> tuple[str, Any]:
    """By what tracking errs from keyframe to keyframe, by what the scene told, and by the rule."""
    errors, H = steps(found)
    told, off = along_the_axes(errors, H)
    rows = []
    for low, high in pairwise(TOLD_MM):
        there = (told >= low) & (told < high)
        if not there.any():
            continue
        rule = np.sqrt((1e3 * TRACKED_SIGMAS[3]) ** 2 + (TOO_SURE * told[there]) ** 2)
        sigmas = [float(np.sqrt(np.mean(v**2))) for v in (told[there], rule, off[there])]
        rows.append([low, high, there.sum(), *sigmas, NORMAL * np.median(np.abs(off[there]))])
    turn, place, sure = likeliest(errors, H)
    squared = by_information(errors, blurred(H / TOO_SURE**2, tracked()))
    head = ["told by H [mm]", "axes", "told", "rule", "error", f"{NORMAL} median \\|error\\|"]
    cells = [
        [f"{low:g} to {high:g}" if high < TOLD_MM[-1] else f"{low:g} on", str(number),
         *(f"{value:.2f}" for value in values)]
        for low, high, number, *values in rows
    ]  # fmt: skip
    text = (
        "## From one keyframe to the next\n\n"
        "Where the scene held every frame between. H is the scene's at the later one; its position "
        "part is told along its three axes. The rule is C + k² H⁻¹. Root mean squares [mm], and "
        "what they would be if errors were as their median and normal.\n\n"
        + table(head, cells)
        + f"\n\nBy the rule eᵀΩe has the mean {squared.mean():.1f} and the median "
        f"{np.median(squared):.1f} over {len(squared)} steps. What makes these errors likeliest "
        f"(maximum likelihood, normal errors): {np.degrees(turn):.3f}° and {1e3 * place:.2f} mm in "
        f"C, k = {sure:.2f}; in the code {np.degrees(TRACKED_SIGMAS[0]):.2f}°, "
        f"{1e3 * TRACKED_SIGMAS[3]:.1f} mm, {TOO_SURE:g}."
    )
    named = ("from_mm", "to_mm", "axes", "told_mm", "rule_mm", "error_mm", "by_median_mm")
    return text, {
        "axes": [dict(zip(named, map(float, row), strict=True)) for row in rows],
        "likeliest": {"turn_rad": turn, "place_m": place, "too_sure": sure},
        **Squares.of(squared)._asdict(),
    }


def of_edges(found: Sequence[dict[str, Any]]) -> tuple[str, Any]:
    """What the final graph's edges tell and err by, by the turn between their two views."""
    edges = np.concatenate([np.array(record["edges"]) for record in found])
    consecutive, turns = edges[:, 0] > 0, np.degrees(edges[:, 1])
    kinds = {"one keyframe and the next": consecutive} | {
        f"others, {low:g} to {high:g}° apart": ~consecutive & (turns >= low) & (turns < high)
        for low, high in pairwise(TURNS_DEG)
    }
    counted = {name: Squares.of(edges[there, 2]) for name, there in kinds.items() if there.any()}
    rows = [[name, *squares.cells] for name, squares in counted.items()]
    text = (
        "## Edges of the pose graph\n\n"
        "eᵀΩe of what an edge says of the two keyframes that it joins, when the scan has ended.\n\n"
        + table(["", *SQUARES], rows)
    )
    return text, {name: squares._asdict() for name, squares in counted.items()}


def steps(
    found: Sequence[dict[str, Any]],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, 6) errors and (n, 6, 6) H of all scans."""
    lines = np.concatenate([np.array(record["steps"]).reshape(-1, 27) for record in found])
    H = np.zeros((len(lines), 6, 6))
    rows, columns = np.triu_indices(6)
    H[:, rows, columns] = H[:, columns, rows] = lines[:, 6:]
    return lines[:, :6], H


def along_the_axes(
    errors: NDArray[np.float64], H: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(3n,) told standard deviations of the place along its principal axes [mm], and the errors."""
    covariances = np.linalg.inv(H + 1e-3 * np.eye(6))[:, 3:, 3:]
    variances, axes = np.linalg.eigh(covariances)
    off = np.einsum("nij,ni->nj", axes, errors[:, 3:])
    return 1e3 * np.sqrt(variances).ravel(), 1e3 * off.ravel()


def by_information(errors: NDArray[np.float64], omega: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) eᵀΩe of (n, 6) errors and (n, 6, 6) information."""
    return np.einsum("ni,nij,nj->n", errors, omega, errors)


def tracked(turn: float = TRACKED_SIGMAS[0], place: float = TRACKED_SIGMAS[3]) -> NDArray[Any]:
    """(6, 6) C⁻¹."""
    return np.diag([turn**-2.0] * 3 + [place**-2.0] * 3)


def likeliest(errors: NDArray[np.float64], H: NDArray[np.float64]) -> tuple[float, ...]:
    """The standard deviations in C [rad], [m] and the k that make the errors likeliest."""

    def cost(logs: NDArray[np.float64]) -> float:
        turn, place, sure = np.exp(logs)
        omega = blurred(H / sure**2, tracked(turn, place))
        return float(np.sum(by_information(errors, omega) - np.linalg.slogdet(omega)[1]))

    begin = np.log([TRACKED_SIGMAS[0], TRACKED_SIGMAS[3], TOO_SURE])
    return tuple(np.exp(minimize(cost, begin, method="Nelder-Mead").x).tolist())


if __name__ == "__main__":
    sys.exit(main())
