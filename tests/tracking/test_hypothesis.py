"""The sequential test of hypotheses: laws of its bookkeeping."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from circumspect.tracking.fixed_lag_smoother import FixedLagSmoother
from circumspect.tracking.hypothesis import (
    DECISION_RATIO,
    MAX_FRAME_RATIO,
    MAX_HYPOTHESES,
    Hypothesis,
    survivors,
)
from circumspect.tracking.scan_likelihood import ScanLikelihood

RATIOS = st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=8)


def at(x: float, frame_log_ratio: float, log_ratio: float = 0.0) -> Hypothesis:
    T = np.eye(4)
    T[0, 3] = x
    smoother = FixedLagSmoother.from_pose(T, np.eye(6) * 1e-6, 0.05)
    return Hypothesis(smoother, frame_log_ratio=frame_log_ratio, log_ratio=log_ratio)


@given(RATIOS)
def test_the_best_come_first_and_the_best_has_zero(ratios: list[float]) -> None:
    kept = survivors([at(float(n), ratio) for n, ratio in enumerate(ratios)])
    found = [hypothesis.log_ratio for hypothesis in kept]
    assert found[0] == 0.0
    assert found == sorted(found, reverse=True)
    assert 1 <= len(kept) <= MAX_HYPOTHESES
    assert min(found) > -DECISION_RATIO


@given(st.floats(-1e6, 1e6))
def test_one_frame_alone_decides_nothing(ratio: float) -> None:
    """However bad a frame fits one of two hypotheses, the other is accepted after two frames."""
    two = survivors([at(0.0, 0.0), at(1.0, ratio)])
    assert len(two) == 2
    assert abs(two[1].log_ratio) <= MAX_FRAME_RATIO


def test_a_hypothesis_that_keeps_losing_is_dropped() -> None:
    alive = [at(0.0, 0.0), at(1.0, 0.0)]
    for _ in range(2):
        alive = survivors([at(0.0, 5.0, alive[0].log_ratio), at(1.0, -15.0, alive[-1].log_ratio)])
    assert [float(h.T_map_camera[0, 3]) for h in alive] == [0.0]


def test_hypotheses_at_the_same_pose_are_merged() -> None:
    kept = survivors([at(0.0, 1.0), at(0.01, 2.0), at(1.0, 0.0)])
    assert [float(h.T_map_camera[0, 3]) for h in kept] == [0.01, 1.0]


@given(RATIOS, st.floats(-100, 100))
def test_only_differences_count(ratios: list[float], offset: float) -> None:
    first = survivors([at(float(n), ratio) for n, ratio in enumerate(ratios)])
    second = survivors([at(float(n), ratio + offset) for n, ratio in enumerate(ratios)])
    np.testing.assert_allclose(
        [h.log_ratio for h in first], [h.log_ratio for h in second], atol=1e-9
    )


@given(st.integers(100, 400), st.floats(0.2, 0.9), st.integers(1, 20))
def test_points_in_unknown_space_decide_nothing(count: int, share: float, frames: int) -> None:
    """Where the map ends another place explains more points; that makes it no more likely."""
    known = np.arange(count) < round((1 - share) * count)
    everywhere = ScanLikelihood(
        float(count), contributions=np.ones(count), unknown=np.zeros(count, bool)
    )
    at_the_rim = ScanLikelihood(float(known.sum()), contributions=1.0 * known, unknown=~known)
    alive, unmeasured = [at(0.0, 0.0), at(1.0, 0.0)], [at(0.0, 0.0), at(1.0, 0.0)]
    for _ in range(frames):
        alive = survivors(explaining(alive, everywhere, at_the_rim))
        assert [hypothesis.log_ratio for hypothesis in alive] == [0.0, 0.0]
    # The mean of a pose that no scan has determined is not where the camera is.
    unmeasured[1] = replace(unmeasured[1], unmeasured=1.0)
    assert survivors(explaining(unmeasured, everywhere, at_the_rim))[1].log_ratio < 0


def explaining(
    alive: list[Hypothesis], first: ScanLikelihood, second: ScanLikelihood
) -> list[Hypothesis]:
    """Two hypotheses after a frame, the one farther along second."""
    ordered = sorted(alive, key=lambda hypothesis: float(hypothesis.T_map_camera[0, 3]))
    return [
        replace(hypothesis, frame_log_ratio=likelihood.total, likelihood=likelihood)
        for hypothesis, likelihood in zip(ordered, (first, second), strict=True)
    ]


@given(st.floats(50, 2000), st.floats(0, 0.09), st.integers(1, 40))
def test_errors_of_the_map_decide_nothing(support: float, share: float, frames: int) -> None:
    """Two places that look alike stay possible, however many frames fit one slightly better."""
    alive = [at(0.0, 0.0), at(1.0, 0.0)]
    likelihood = ScanLikelihood(support=support)
    for _ in range(frames):
        better = replace(alive[0], frame_log_ratio=support, likelihood=likelihood)
        worse = replace(alive[1], frame_log_ratio=support * (1 - share), likelihood=likelihood)
        alive = survivors([better, worse])
        assert [hypothesis.log_ratio for hypothesis in alive] == [0.0, 0.0]
