"""Committees are built and evaluated as their page describes."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.committees import committees, figures

from circumspect.datasets import ObjectSet


def test_committees_are_single_networks_and_those_with_the_first() -> None:
    assert list(committees(["a", "b", "c"])) == [
        ("a",), ("b",), ("c",), ("a", "b"), ("a", "c"), ("a", "b", "c"),
    ]  # fmt: skip


def test_figures_of_two_networks_use_their_mean_over_objects_and_yaws() -> None:
    rng = np.random.default_rng(0)
    objects = ObjectSet(
        rng.random((3, 8, 3), np.float32),
        np.array([0, 0, 1]),
        np.array(["mug_1", "mug_2", "pan_1"]),
        ("mug", "pan"),
    )
    # Two yaws. The second mug is a pan to one network and, more probably, a mug to the other; the
    # pan is classified wrongly at the second yaw.
    one = np.array([[[0.9, 0.1], [0.4, 0.6], [0.2, 0.8]]] * 2)
    other = np.array([[[0.9, 0.1], [0.8, 0.2], [0.2, 0.8]], [[0.9, 0.1], [0.8, 0.2], [0.9, 0.1]]])
    found = figures([one, other], objects)
    assert found["accuracy"] == pytest.approx((3 + 2) / 6)
    assert found["worst"] == pytest.approx(2 / 3)
    assert found["flip_rate"] == pytest.approx(1 / 3)
    assert found["mean_class_accuracy"] == pytest.approx((1 + 0.5) / 2)
    assert figures([one], objects)["accuracy"] == pytest.approx(2 / 3)
