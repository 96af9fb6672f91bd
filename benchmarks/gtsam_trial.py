"""GTSAM and the project's solvers on the same graphs: time and difference of the results.

    pip install gtsam==4.3.0          # not a dependency of the project
    python -m benchmarks.gtsam_trial

A robot drives round an object three and a half times. The keyframe graph has its odometry and
robust factors between keyframes that see the same side. The window has 15 poses with a measured
pose each, and odometry whose scale is estimated. `docs/development/solvers.md` discusses the
results.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from benchmarks.report import write_page
from circumspect.geometry import se3_matrices
from circumspect.geometry.composition import distances
from circumspect.motion import RelativeMotion
from circumspect.pose_graph import BetweenFactor, PoseGraph
from circumspect.pose_graph.normal_equations import CAUCHY_SCALE
from circumspect.tracking.fixed_lag_smoother import LAG, FixedLagSmoother
from circumspect.tracking.smoother_window import PoseFactor

SIZES = (30, 60, 120, 240)
ORBITS = 3.5
STEP = np.array([0.0, 0.0, 0.1, 0.2, 0.0, 0.0])
"""Motion from one keyframe to the next [rad, m]."""
ODOMETRY_SIGMAS = np.array([0.002] * 3 + [0.004] * 3)
SCAN_SIGMAS = np.array([0.001] * 3 + [0.002] * 3)
OUTLIERS = 0.05
"""Share of wrong loop closures."""
REPEATS = 5
FRAMES = 60
"""Number of frames of the drive for the window."""

Pose = NDArray[np.floating]


def graph(count: int) -> PoseGraph:
    """Keyframes with odometry, and factors between those on the same side."""
    rng = np.random.default_rng(count)
    truth: list[Pose] = [np.eye(4)]
    for _ in range(count - 1):
        truth.append(truth[-1] @ se3_matrices.exp(STEP * ORBITS * 2 * np.pi / (0.1 * count)))
    factors = [_between(truth, n, n + 1, ODOMETRY_SIGMAS, rng) for n in range(count - 1)]
    per_orbit = round(count / ORBITS)
    for n in range(count):
        for other in (n + 2, n + 4, n + per_orbit):
            if other < count:
                wrong = rng.random() < OUTLIERS
                factors.append(_between(truth, n, other, SCAN_SIGMAS, rng, True, wrong))
    poses = [RigidTransform.identity()]
    for factor in factors[: count - 1]:
        poses.append(poses[-1] * factor.T_first_second)
    return PoseGraph(tuple(poses), tuple(factors))


def _between(
    truth: Sequence[Pose], first: int, second: int, sigmas: NDArray[np.float64],
    rng: np.random.Generator, robust: bool = False, wrong: bool = False,
) -> BetweenFactor:  # fmt: skip
    noise = sigmas * rng.normal(size=6) + (0.3 * rng.normal(size=6) if wrong else 0)
    measured = se3_matrices.inverse(truth[first]) @ truth[second] @ se3_matrices.exp(noise)
    T = RigidTransform.from_matrix(measured)
    return BetweenFactor(first, second, T, np.diag(sigmas**-2.0), robust)


def by_gtsam(problem: PoseGraph) -> Pose:
    """(n, 4, 4) the optimum by GTSAM's Levenberg-Marquardt method."""
    import gtsam  # pyright: ignore[reportMissingImports]

    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    values_of = [gtsam.Pose3(pose.as_matrix()) for pose in problem.poses]
    for number, pose in enumerate(values_of):
        values.insert(number, pose)
    fixed = gtsam.noiseModel.Isotropic.Sigma(6, 1e-9)
    factors.add(gtsam.PriorFactorPose3(0, values_of[0], fixed))
    cauchy = gtsam.noiseModel.mEstimator.Cauchy.Create(CAUCHY_SCALE)
    for factor in problem.between_factors:
        noise = gtsam.noiseModel.Gaussian.Information(factor.information)
        if factor.robust:
            noise = gtsam.noiseModel.Robust.Create(cauchy, noise)
        measured = gtsam.Pose3(factor.T_first_second.as_matrix())
        factors.add(gtsam.BetweenFactorPose3(factor.first, factor.second, measured, noise))
    parameters = gtsam.LevenbergMarquardtParams()
    parameters.setRelativeErrorTol(1e-9)
    found = gtsam.LevenbergMarquardtOptimizer(factors, values, parameters).optimize()
    return np.stack([found.atPose3(number).matrix() for number in range(len(problem.poses))])


def drive() -> list[tuple[RelativeMotion, Pose]]:
    """Odometry that slips by 5 %, and measured poses."""
    rng = np.random.default_rng(1)
    pose, rows = np.eye(4), []
    for _ in range(FRAMES):
        pose = pose @ se3_matrices.exp(0.25 * STEP)
        change = 0.25 * STEP * 1.05 + 0.2 * ODOMETRY_SIGMAS * rng.normal(size=6)
        by_scale = np.zeros((6, 2))
        by_scale[3:, 0], by_scale[:3, 1] = change[3:], change[:3]
        covariance = np.diag((0.2 * ODOMETRY_SIGMAS) ** 2)
        motion = RelativeMotion(se3_matrices.exp(change), by_scale, covariance)
        rows.append((motion, pose @ se3_matrices.exp(SCAN_SIGMAS * rng.normal(size=6))))
    return rows


def smoothed(rows: list[tuple[RelativeMotion, Pose]]) -> tuple[Pose, float]:
    """The last pose, and milliseconds a frame."""
    smoother = FixedLagSmoother.from_pose(np.eye(4), np.eye(6) * 1e-8, 0.05)
    times = []
    for motion, measured in rows:
        began = time.perf_counter()
        smoother = smoother.extended(
            motion, measured, PoseFactor(measured, np.diag(SCAN_SIGMAS**-2.0))
        )
        times.append(time.perf_counter() - began)
    return smoother.T_map_camera, 1e3 * float(np.median(times[LAG:]))


def smoothed_by_gtsam(rows: list[tuple[RelativeMotion, Pose]]) -> tuple[Pose, float]:
    """The same by GTSAM's fixed-lag smoother, with odometry of a known scale.

    A custom factor, as for the scale, would be a Python callback and dominate the time. It is left
    out in GTSAM's favour.
    """
    import gtsam  # pyright: ignore[reportMissingImports]

    smoother = gtsam.IncrementalFixedLagSmoother(float(LAG), gtsam.ISAM2Params())
    cauchy = gtsam.noiseModel.mEstimator.Cauchy.Create(6.0)
    scans = gtsam.noiseModel.Robust.Create(cauchy, gtsam.noiseModel.Diagonal.Sigmas(SCAN_SIGMAS))
    start = gtsam.noiseModel.Isotropic.Sigma(6, 1e-4)
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    factors.add(gtsam.PriorFactorPose3(0, gtsam.Pose3(), start))
    values.insert(0, gtsam.Pose3())
    smoother.update(factors, values, {0: 0.0})
    times, last = [], np.eye(4)
    for number, (motion, measured) in enumerate(rows, 1):
        began = time.perf_counter()
        factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        noise = gtsam.noiseModel.Gaussian.Covariance(motion.covariance + np.diag(STEP**2 * 2e-4))
        moved = gtsam.Pose3(motion.T_before_now)
        factors.add(gtsam.BetweenFactorPose3(number - 1, number, moved, noise))
        factors.add(gtsam.PriorFactorPose3(number, gtsam.Pose3(measured), scans))
        values.insert(number, gtsam.Pose3(measured))
        smoother.update(factors, values, {number: float(number)})
        last = smoother.calculateEstimatePose3(number).matrix()
        times.append(time.perf_counter() - began)
    return last, 1e3 * float(np.median(times[LAG:]))


def _milliseconds(work: Callable[[], Any]) -> float:
    times = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        times.append(time.perf_counter() - began)
    return 1e3 * float(np.median(times))


def main() -> int:
    """Compare and write the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    rows = []
    for count in SIZES:
        problem = graph(count)
        ours = np.stack([pose.as_matrix() for pose in problem.optimised().poses])
        apart = distances(ours, by_gtsam(problem))[0].max()
        row = count, len(problem.between_factors), *map(
            _milliseconds, (problem.optimised, lambda problem=problem: by_gtsam(problem))
        ), 1e3 * float(apart)  # fmt: skip
        rows.append(row)
    (own, own_ms), (other, other_ms) = smoothed(drive()), smoothed_by_gtsam(drive())
    apart = 1e3 * float(distances(own, other)[0])
    table = "\n".join(
        ["| keyframes | factors | ours [ms] | GTSAM [ms] | apart [mm] |", "|---|---|---|---|---|"]
        + ["| {} | {} | {:.1f} | {:.1f} | {:.3f} |".format(*row) for row in rows]
    )
    text = (
        f"GTSAM {version('gtsam')}, NumPy {version('numpy')}, SciPy {version('scipy')}; medians "
        f"of {REPEATS}.\n\n## Keyframe graph\n\n{table}\n\n## Window of {LAG} poses\n\n"
        f"A frame takes {own_ms:.2f} ms with the project's kernel, which estimates the odometry "
        f"scale as well, and {other_ms:.2f} ms with `IncrementalFixedLagSmoother`, which does "
        f"not. The last poses are {apart:.1f} mm apart."
    )
    figures = {"graphs": rows, "window_ms": [own_ms, other_ms], "window_apart_mm": apart}
    write_page("gtsam_trial", "GTSAM beside the solvers", "python -m benchmarks.gtsam_trial", text,
               figures)  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
