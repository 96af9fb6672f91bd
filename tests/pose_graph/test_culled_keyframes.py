"""What represents a culled keyframe."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import se3_matrices
from circumspect.pose_graph.keyframe_graph import CulledKeyframes


def test_substitutes_are_followed_and_the_oldest_dropped() -> None:
    culled, step = CulledKeyframes(max_culled=3), se3_matrices.exp(np.array([0, 0, 0, 1.0, 0, 0]))
    for number in range(3):
        culled.add(number, number + 1, step)
    number, T = culled.substitute(0, np.eye(4))
    assert number == 3
    np.testing.assert_allclose(T[:3, 3], [3.0, 0, 0])
    for number in range(3, 50):
        culled.add(number, number + 1, step)
    assert len(culled) == 3
    assert culled.substitute(0, step)[0] == 0, "forgotten: it represents itself"
    assert culled.substitute(47, step)[0] == 50
