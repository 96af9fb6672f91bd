r"""Leaves out odometry that is on another clock than the images, or does not fit their motion.

Odometry that lags by δ reports at the time t the pose of t - δ. Let $r_k$ be the motion of the
base between two frames by registration and $o_k(\delta)$ that by odometry between the times
$t_{k-1} + \delta$ and $t_k + \delta$. With independent normal errors of standard deviation
$\sigma_k$,

$$\log p(\delta) = -\frac{1}{2} \sum_k \min(\|(r_k - o_k(\delta)) / \sigma_k\|^2, c).$$

A wheel that slips turns the robot, so that the variance of a rotation grows with the distance.
Without that, a lag explains slip by chance while the robot turns less and less.

The clocks differ if a δ beyond usual latencies explains the motions significantly better than all
usual ones (likelihood ratio test), and if none of the usual ones explains them: slip is correlated
in time, so that a lag may fit it better by chance. How much wheels slip depends on the floor: the
variances have a common scale, which is estimated from the errors that δ leaves. A constant velocity
says nothing about δ, and does no harm.

Odometry is wrong if most motions contradict it at every lag, as with a stuck encoder. Motions that
are too small to contradict stuck odometry do not count.
"""

from __future__ import annotations

import logging
from collections import deque
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from circumspect.geometry import PlanarPose
from circumspect.sensing import RgbdFrame
from circumspect.tracking.pose_estimate import PoseEstimate

MAX_STAMP_DIFFERENCE_S = 1.0
"""Odometry with a stamp farther from that of its frame belongs to another clock."""
MIN_FRAMES, MIN_SPAN_S, MIN_INTERVAL_S = 20, 20.0, 0.2
"""Minimum number of frames and duration [s] of the window; frames in it are at least
`MIN_INTERVAL_S` apart [s]."""
RECENT_MOTIONS, MAX_CONTRADICTING = 10, 5
"""Odometry is wrong if more than `MAX_CONTRADICTING` of this many last motions contradict it, and
right again if no more of as many do."""
DIFFERENT_CLOCKS = "odometry and images are on different clocks"
CONTRADICTED = "odometry contradicts the motion of the images"
_log = logging.getLogger(__name__)
LAGS_S = np.linspace(-1.2, 1.2, 25)
"""Tested lags of the odometry."""
MAX_LATENCY_S = 0.25
"""Smaller lags are usual latencies."""
TRANSLATION_SIGMA, ROTATION_SIGMA, RELATIVE_SIGMA = 0.003, float(np.radians(0.25)), 0.07
"""Standard deviation of a motion: constants [m], [rad], and a fraction of the motion."""
TURN_VARIANCE = 2.3e-3
"""Variance of a rotation per distance [rad²/m]: two wheels 0.33 m apart that slip independently,
each with half of the variance of `robot.wheel_odometry`. That is of many patches of floor; within
one, of 0.1 m, slip is constant, and motions between frames are about half as long."""
MAX_SQUARED_ERROR = 25.0
"""c: a single motion, as of a jump, contributes no more."""
MIN_LOG_RATIO = 15.0
"""Log-likelihood ratio from which on the clocks differ …"""
MAX_COST_SHARE = 0.5
"""… if the lag leaves at most this fraction of the squared errors unexplained …"""
EXPECTED_COST = 1.5
"""… and if usual lags leave more than this per motion: half of χ² with three degrees of freedom."""
MIN_NOISE = 0.5
"""Smallest scale of the variances above; the largest is 1."""


class OdometryCheck:
    """Removes odometry from frames if its clock is not that of the images, or if it is wrong.

    Odometry that is wrong is used again once it fits the images.

    Attributes:
        warning: Why odometry is not used; empty if it is.
    """

    def __init__(self) -> None:
        """Assume that the odometry is right."""
        self.warning = ""
        self._lag: float | None = None
        self._is_wrong = False
        self._logged = set[str]()
        self._rows: deque[tuple[float, ...]] = deque()

    def filter(self, frame: RgbdFrame) -> RgbdFrame:
        """Check the next frame: the same without its odometry if that is not to be used."""
        self.warning = self._clock_warning(frame)
        if not self.warning and self._is_wrong and frame.odometry is not None:
            self.warning = CONTRADICTED
        if not self.warning:
            return frame
        kind = self.warning.split(":")[0]
        if kind not in self._logged:
            _log.warning("%s; poses are found without odometry", self.warning)
            self._logged.add(kind)
        return replace(frame, odometry=None)

    def _clock_warning(self, frame: RgbdFrame) -> str:
        if self._lag is not None:
            order = "lags behind" if self._lag > 0 else "runs ahead of"
            return f"{DIFFERENT_CLOCKS}: odometry {order} the images by {abs(self._lag):.1f} s"
        apart = _stamp_difference(frame)
        if apart <= MAX_STAMP_DIFFERENCE_S:
            return ""
        return f"{DIFFERENT_CLOCKS}: their stamps differ by {apart:.1f} s"

    def update(self, frame: RgbdFrame, pose: PoseEstimate) -> None:
        """Compare the motion of a frame with its odometry.

        Args:
            frame: The frame, before it was filtered.
            pose: Its pose.
        """
        if frame.odometry is None or pose.T_map_base is None:
            return
        if _stamp_difference(frame) > MAX_STAMP_DIFFERENCE_S:
            return
        if self._rows and frame.stamp - self._rows[-1][0] < MIN_INTERVAL_S - 1e-6:
            return
        registered = _row(pose.T_map_base) if pose.reliable else (np.nan,) * 3
        self._rows.append((frame.stamp, *registered, *_row(frame.odometry.T_odom_base)))
        while len(self._rows) > MIN_FRAMES and self._rows[-1][0] - self._rows[0][0] > MIN_SPAN_S:
            self._rows.popleft()
        rows = np.array(self._rows)
        motions = rows[:, 0], rows[:, 1:4], rows[:, 4:]
        recent = contradicting_motions(*motions)[-RECENT_MOTIONS:]
        # Too few motions say nothing new.
        if len(recent) == RECENT_MOTIONS or not self._is_wrong:
            self._is_wrong = int(recent.sum()) > MAX_CONTRADICTING
        # An even motion says nothing of a lag that is known.
        self._lag = None if self._is_wrong else odometry_lag(*motions) or self._lag


def _stamp_difference(frame: RgbdFrame) -> float:
    return 0.0 if frame.odometry is None else abs(frame.odometry.stamp - frame.stamp)


def _row(pose: PlanarPose) -> tuple[float, float, float]:
    return pose.x, pose.y, pose.yaw


def odometry_lag(
    stamps: NDArray[np.floating],
    registered: NDArray[np.floating],
    odometry: NDArray[np.floating],
) -> float | None:
    """The lag of odometry on another clock.

    Args:
        stamps: (n,) ascending times of frames [s].
        registered: (n, 3) x, y [m] and yaw [rad] of the base by registration; NaN where unknown.
        odometry: (n, 3) the same by odometry, in any frame.

    Returns:
        Lag behind the images [s]; None if the motions do not speak against a common clock.
    """
    squares = _squared_errors(np.zeros(1), stamps, registered, odometry)
    if _cost(squares / MIN_NOISE) < MIN_LOG_RATIO:
        return None
    squares = _squared_errors(LAGS_S, stamps, registered, odometry)
    usual = np.abs(LAGS_S) <= MAX_LATENCY_S
    comparable = np.isfinite(squares[usual]).all(axis=0)
    ratios = np.full(len(LAGS_S), -np.inf)
    for number in np.flatnonzero(~usual):
        # All lags that are compared explain the same motions.
        motions = comparable & np.isfinite(squares[number])
        expected = EXPECTED_COST * max(1, motions.sum())
        unscaled = _cost(squares[number, motions])
        noise = np.clip(unscaled / expected, MIN_NOISE, 1.0)
        cost = _cost(squares[number, motions] / noise)
        null = _cost(squares[usual][:, motions] / noise).min()
        if cost <= MAX_COST_SHARE * null and unscaled <= expected < null:
            ratios[number] = null - cost
    best = int(np.argmax(ratios))
    return float(LAGS_S[best]) if ratios[best] >= MIN_LOG_RATIO else None


def contradicting_motions(
    stamps: NDArray[np.floating],
    registered: NDArray[np.floating],
    odometry: NDArray[np.floating],
) -> NDArray[np.bool_]:
    """Which motions no lag of the odometry explains.

    Args:
        stamps: (n,) ascending times of frames [s].
        registered: (n, 3) as for `odometry_lag`.
        odometry: (n, 3) as for `odometry_lag`.

    Returns:
        One flag for each motion that is known, and that odometry without motion would contradict
        if it were wrong: a robot that stands still says nothing of stuck odometry.
    """
    squares = _squared_errors(LAGS_S, stamps, registered, odometry)
    standing = _squared_errors(np.zeros(1), stamps, registered, 0 * odometry)[0]
    moved = _squared_errors(LAGS_S, stamps, 0 * registered, odometry)
    known = np.isfinite(squares).any(axis=0)
    squares, standing, moved = squares[:, known], standing[known], moved[:, known]
    informative = (standing >= MAX_SQUARED_ERROR) | (np.nanmin(moved, axis=0) >= MAX_SQUARED_ERROR)
    return (np.nanmin(squares, axis=0) >= MAX_SQUARED_ERROR)[informative]


def _cost(squares: NDArray[np.floating]) -> NDArray[np.floating]:
    """(…) negative log-likelihoods of (…, n) squared errors; those of unknown motions are 0."""
    return np.nansum(np.minimum(squares, MAX_SQUARED_ERROR), axis=-1) / 2


def _squared_errors(
    lags: NDArray[np.floating],
    stamps: NDArray[np.floating],
    registered: NDArray[np.floating],
    odometry: NDArray[np.floating],
) -> NDArray[np.floating]:
    """(m, n - 1) squared errors of the n - 1 motions for m lags, in σ; NaN where unknown."""
    by_scans = _motions(registered)
    times = stamps + lags[:, None]
    columns = odometry[:, 0], odometry[:, 1], np.unwrap(odometry[:, 2])
    lagged = [np.interp(times, stamps, column, np.nan, np.nan) for column in columns]
    by_wheels = _motions(np.stack(lagged, axis=-1))
    distances = np.linalg.norm(by_scans[:, :2], axis=1)
    translation_sigmas = TRANSLATION_SIGMA + RELATIVE_SIGMA * distances
    rotation_sigmas = np.hypot(
        ROTATION_SIGMA + RELATIVE_SIGMA * np.abs(by_scans[:, 2]), np.sqrt(TURN_VARIANCE * distances)
    )
    sigmas = np.column_stack([translation_sigmas, translation_sigmas, rotation_sigmas])
    errors = (by_scans - by_wheels) / sigmas
    return (errors**2).sum(axis=-1)


def _motions(poses: NDArray[np.floating]) -> NDArray[np.floating]:
    """(…, n - 1, 3) motions between consecutive poses (…, n, 3), in the frames of the former."""
    step, yaw = np.diff(poses, axis=-2), poses[..., :-1, 2]
    cosine, sine = np.cos(yaw), np.sin(yaw)
    x, y, turn = np.moveaxis(step, -1, 0)
    turn = np.arctan2(np.sin(turn), np.cos(turn))
    return np.stack([cosine * x + sine * y, cosine * y - sine * x, turn], axis=-1)
