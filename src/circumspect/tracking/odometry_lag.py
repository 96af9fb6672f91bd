r"""Whether wheel odometry fits the motions of the images, and at which lag.

Odometry that lags by δ reports at the time t the pose of t - δ. Let $r_k$ be the motion of the
base between two frames by registration and $o_k(\delta)$ that by odometry between the times
$t_{k-1} + \delta$ and $t_k + \delta$. With independent normal errors of standard deviation
$\sigma_k$,

$$\log p(\delta) = -\frac{1}{2} \sum_k \min(\|(r_k - o_k(\delta)) / \sigma_k\|^2, c).$$

The clocks differ if a δ beyond usual latencies explains the motions significantly better than all
usual ones (likelihood ratio test), and if none of the usual ones explains them: slip is correlated
in time, so that a lag may fit it better by chance. A constant velocity says nothing about δ, and
does no harm.

Odometry is wrong if most motions contradict it at every lag, as with a stuck encoder. Motions that
are too small to contradict stuck odometry do not count.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

LAGS_S = np.linspace(-1.2, 1.2, 25)
"""Tested lags of the odometry."""
MAX_LATENCY_S = 0.25
"""Smaller lags are usual latencies."""
TRANSLATION_SIGMA, ROTATION_SIGMA, RELATIVE_SIGMA = 0.003, float(np.radians(0.25)), 0.07
"""Standard deviation of a motion: constants [m], [rad], and a share of the motion."""
MAX_SQUARED_ERROR = 25.0
"""c: a single motion, as of a jump, contributes no more."""
MIN_LOG_RATIO = 15.0
"""Log-likelihood ratio from which on the clocks differ …"""
MAX_COST_SHARE = 0.5
"""… if the lag leaves at most this share of the squared errors unexplained …"""
EXPECTED_COST = 1.5
"""… and if usual lags leave more than this per motion: half of χ² with three degrees of freedom."""


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
    costs = _costs(np.zeros(1), stamps, registered, odometry)
    if np.nansum(costs) < MIN_LOG_RATIO:
        return None
    costs = _costs(LAGS_S, stamps, registered, odometry)
    usual = np.abs(LAGS_S) <= MAX_LATENCY_S
    comparable = np.isfinite(costs[usual]).all(axis=0)
    ratios = np.full(len(LAGS_S), -np.inf)
    for number in np.flatnonzero(~usual):
        # All lags that are compared explain the same motions.
        motions = comparable & np.isfinite(costs[number])
        null = costs[usual][:, motions].sum(axis=1).min()
        cost = costs[number, motions].sum()
        expected = EXPECTED_COST * motions.sum()
        if cost <= min(MAX_COST_SHARE * null, expected) and null > expected:
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
    costs = _costs(LAGS_S, stamps, registered, odometry)
    standing = _costs(np.zeros(1), stamps, registered, 0 * odometry)[0]
    moved = _costs(LAGS_S, stamps, 0 * registered, odometry)
    known = np.isfinite(costs).any(axis=0)
    costs, standing, moved = costs[:, known], standing[known], moved[:, known]
    limit = MAX_SQUARED_ERROR / 2
    informative = (standing >= limit) | (np.nanmin(moved, axis=0) >= limit)
    return (np.nanmin(costs, axis=0) >= limit)[informative]


def _costs(
    lags: NDArray[np.floating],
    stamps: NDArray[np.floating],
    registered: NDArray[np.floating],
    odometry: NDArray[np.floating],
) -> NDArray[np.floating]:
    """(m, n - 1) negative log-likelihoods of the n - 1 motions for m lags; NaN where unknown."""
    by_scans = _motions(registered)
    times = stamps + lags[:, None]
    columns = odometry[:, 0], odometry[:, 1], np.unwrap(odometry[:, 2])
    lagged = [np.interp(times, stamps, column, np.nan, np.nan) for column in columns]
    by_wheels = _motions(np.stack(lagged, axis=-1))
    translation_sigma = TRANSLATION_SIGMA + RELATIVE_SIGMA * np.linalg.norm(by_scans[:, :2], axis=1)
    rotation_sigma = ROTATION_SIGMA + RELATIVE_SIGMA * np.abs(by_scans[:, 2])
    errors = by_scans - by_wheels
    squares = (errors[..., :2] ** 2).sum(axis=-1) / translation_sigma**2
    squares += errors[..., 2] ** 2 / rotation_sigma**2
    return np.minimum(squares, MAX_SQUARED_ERROR) / 2


def _motions(poses: NDArray[np.floating]) -> NDArray[np.floating]:
    """(…, n - 1, 3) motions between consecutive poses (…, n, 3), in the frames of the former."""
    step, yaw = np.diff(poses, axis=-2), poses[..., :-1, 2]
    cosine, sine = np.cos(yaw), np.sin(yaw)
    x, y, turn = np.moveaxis(step, -1, 0)
    turn = np.arctan2(np.sin(turn), np.cos(turn))
    return np.stack([cosine * x + sine * y, cosine * y - sine * x, turn], axis=-1)
