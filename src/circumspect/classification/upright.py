"""Classify objects whose vertical axis is unknown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from circumspect.classification.answer_text import percent
from circumspect.classification.classifier import Classifier
from circumspect.classification.prediction import Prediction
from circumspect.geometry import PointCloud

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

CLOSE = 0.9
"""A pose whose score is at least this fraction of the best one fits nearly as well. Then the pose
of the file is preferred, and the answer is confident only if both have the same label.
`benchmarks.any_way_up` chooses the value on held-back training objects."""

_SAME_POSE = np.cos(np.deg2rad(8.0))


@dataclass(frozen=True)
class WayUp:
    """The answer for one pose.

    Attributes:
        prediction: The answer for this pose.
        pose: From the cloud's coordinates to those of the standing object.
        upright: Whether this is the pose of the file.
    """

    prediction: Prediction
    pose: Rotation
    upright: bool

    @property
    def score(self) -> float:
        """How well the pose fits, 0 … 1: in distribution and probable."""
        known = self.prediction.in_distribution_probability
        return self.prediction.probability * (1.0 if known is None else known)


def classify_any_way_up(
    classifier: Classifier, cloud: PointCloud, *, metric: bool = False
) -> tuple[Prediction, Rotation]:
    """Classify an object in each pose in which it can stand, and return the best answer.

    The pose of the file is tried first and preferred to others that fit nearly as well. If a close
    pose has another label, the answer is not confident. A cloud with a floor in any direction is
    not `in_distribution`; `cut_floor` removes it. Tables and chairs can look like that, too. A
    confident answer for the pose of the file is kept, unless the object without its floor is
    classified otherwise with as much probability.

    Args:
        classifier: Names standing objects.
        cloud: The object's surface, any axis up.
        metric: The points are in metres; without it their scale counts as unknown.

    Returns:
        The answer, and the rotation from the cloud's coordinates to those of the standing object.

    Raises:
        GeometryError: The points span no shape.
    """
    ways = ways_up(classifier, cloud, metric=metric)
    return best_answer(ways, without_floor(classifier, cloud, metric=metric))


def best_answer(
    ways: Sequence[WayUp], floorless: WayUp | None, close: float = CLOSE
) -> tuple[Prediction, Rotation]:
    """The answer of the best pose, not confident where one with another label is close.

    Args:
        ways: The poses that were tried.
        floorless: See `without_floor`.
        close: See `CLOSE`.

    Returns:
        See `classify_any_way_up`.
    """
    ways = ranked(ways, close)
    best = ways[0]
    prediction = best.prediction
    if floorless is not None and not (best.upright and prediction.confident):
        return replace(prediction, in_distribution=False), best.pose
    rivals = [("in another pose", way) for way in ways]
    if floorless is not None and floorless.prediction.in_distribution:
        rivals.append(("without what may be a floor", floorless))
    for where, rival in rivals:
        label, share = rival.prediction.label, percent(rival.prediction.probability)
        if label != prediction.label and rival.score > close * best.score:
            ambiguity = f"{where} it is a {label} ({share})"
            return replace(prediction, ambiguity=ambiguity), best.pose
    return prediction, best.pose


def without_floor(
    classifier: Classifier, cloud: PointCloud, *, metric: bool = False
) -> WayUp | None:
    """The answer for the object without a floor of any direction; None where no floor is found.

    Args:
        classifier: Names standing objects.
        cloud: The object's surface, perhaps with a floor.
        metric: See `classify_any_way_up`.
    """
    from circumspect.geometry.floor_cut import cut_floor

    cut = cut_floor(cloud, any_way_up=True)
    if cut is None:
        return None
    return WayUp(classifier.classify(cut.levelled(), metric=metric), cut.levelling, False)


def ways_up(classifier: Classifier, cloud: PointCloud, *, metric: bool = False) -> list[WayUp]:
    """The answers for the pose that the cloud has and for all in which the object can stand.

    Args:
        classifier: Names standing objects.
        cloud: The object's surface, any axis up.
        metric: See `classify_any_way_up`.

    Returns:
        The best first: poses in distribution before others, then by `WayUp.score`; the pose of
        the file before all that are not clearly better.

    Raises:
        GeometryError: The points span no shape.
    """
    return ranked(
        [
            WayUp(classifier.classify(stood(cloud, pose), metric=metric), pose, number == 0)
            for number, pose in enumerate(poses_to_try(cloud))
        ]
    )


def poses_to_try(cloud: PointCloud) -> list[Rotation]:
    """The pose of the file first, then every other one in which the object can stand.

    Raises:
        GeometryError: The points span no shape.
    """
    # SciPy's spatial part takes as long to import as everything else here.
    from scipy.spatial.transform import Rotation

    from circumspect.geometry.resting_poses import resting_poses

    others = [pose for pose in resting_poses(cloud) if pose.as_matrix()[2, 2] < _SAME_POSE]
    return [Rotation.identity(), *others]


def ranked(ways: Sequence[WayUp], close: float = CLOSE) -> list[WayUp]:
    """Poses in the order of `ways_up`.

    Args:
        ways: One of them that of the file.
        close: See `CLOSE`.
    """
    best_first = sorted(
        ways, key=lambda way: (way.prediction.in_distribution, way.score), reverse=True
    )
    upright = next(way for way in best_first if way.upright)
    if upright.prediction.in_distribution and upright.score > close * best_first[0].score:
        best_first.remove(upright)
        best_first.insert(0, upright)
    return best_first


def stood(cloud: PointCloud, pose: Rotation) -> PointCloud:
    """The cloud, turned."""
    from scipy.spatial.transform import RigidTransform

    return cloud.moved(RigidTransform.from_rotation(pose).as_matrix())
