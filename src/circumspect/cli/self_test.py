"""A quick look whether what is installed works: compiled kernels, shipped classifiers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from circumspect.cli.model_flag import NAMES


@dataclass(frozen=True)
class Check:
    """How one thing went.

    Attributes:
        what: Was tried.
        works: Whether it did.
        told: What came of it, or the fault.
    """

    what: str
    works: bool
    told: str


def self_test() -> list[Check]:
    """Try all; whatever goes wrong is told, not raised."""
    classifiers = (_tried(f"classifier {name}", partial(_classifier, name)) for name in NAMES)
    return [_tried("native kernels", _kernels), *classifiers]


def _tried(what: str, check: Callable[[], str]) -> Check:
    try:
        return Check(what, True, check())
    # Whatever a broken installation raises is what the user has to know.
    except Exception as error:
        return Check(what, False, f"{type(error).__name__}: {error}")


def _kernels() -> str:
    """A grid by the compiled kernel is that of the same in NumPy."""
    import numpy as np

    from circumspect.furniture import make_furniture
    from circumspect.grid import CylindricalGrid, numpy_twin

    cloud = make_furniture("chair", 3).sampled(20_000, 0)
    bounds = CylindricalGrid.fit(cloud)
    began = time.perf_counter()
    states = bounds.hits(cloud).states
    spent = 1e3 * (time.perf_counter() - began)
    if not np.array_equal(states, numpy_twin.hits(bounds, cloud.points_xyz).states):
        raise ArithmeticError("they differ from the same in NumPy; install circumspect anew")
    return f"agree with NumPy; {spent:.1f} ms for 20,000 points"


def _classifier(name: str) -> str:
    """It names a chair."""
    from circumspect.classification import Classifier
    from circumspect.furniture import make_furniture

    cloud = make_furniture("chair", 3).sampled(20_000, 0)
    began = time.perf_counter()
    prediction = Classifier.load(name).classify(cloud)
    spent = 1e3 * (time.perf_counter() - began)
    if prediction.label != "chair":
        raise ArithmeticError(f"it calls a chair {prediction.label}; install circumspect anew")
    return f"names a chair ({prediction.probability:.2f}); {spent:.0f} ms with loading"
