"""Names objects of which nobody knows which way is up."""

from __future__ import annotations

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
"""A pose with this share of the best one's score fits nearly as well. Then the upright pose wins,
and the answer is confident only if both have the same label."""

_SAME_POSE = np.cos(np.deg2rad(8.0))


@dataclass(frozen=True)
class WayUp:
    """The answer for one pose.

    Attributes:
        prediction: What the object is if it stands so.
        pose: From the cloud's coordinates to those of the standing object.
        upright: Whether this is the pose that the file has.
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
    """Stand an object on each face that it can stand on, and take the answer that fits best.

    The pose of the file is tried first, and wins against others that fit nearly as well. Where a
    pose with another label is close, the answer is not confident. A cloud that holds a floor, in
    whatever direction, is not `in_distribution`; `cut_floor` removes it.

    Args:
        classifier: Names standing objects.
        cloud: The object's surface, any axis up.
        metric: The points are in metres; without it their scale counts as unknown.

    Returns:
        The answer, and the rotation from the cloud's coordinates to those of the standing object.

    Raises:
        GeometryError: The points span no shape.
    """
    from circumspect.geometry.floor_cut import cut_floor

    ways = ways_up(classifier, cloud, metric=metric)
    best = ways[0]
    prediction = best.prediction
    accepted_upright = best.upright and prediction.confident
    second = next((way for way in ways if way.prediction.label != prediction.label), None)
    if second is not None and second.score > CLOSE * best.score:
        label, share = second.prediction.label, percent(second.prediction.probability)
        prediction = replace(prediction, ambiguity=f"in another pose it is a {label} ({share})")
    if not accepted_upright and cut_floor(cloud, any_way_up=True) is not None:
        prediction = replace(prediction, in_distribution=False)
    return prediction, best.pose


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
    # SciPy's part for space takes as long to load as all else that names a standing object.
    from scipy.spatial.transform import Rotation

    from circumspect.geometry.resting_poses import resting_poses

    others = [pose for pose in resting_poses(cloud) if pose.as_matrix()[2, 2] < _SAME_POSE]
    ways = [
        WayUp(classifier.classify(stood(cloud, pose), metric=metric), pose, number == 0)
        for number, pose in enumerate([Rotation.identity(), *others])
    ]
    upright = ways[0]
    ways.sort(key=lambda way: (way.prediction.in_distribution, way.score), reverse=True)
    if upright.prediction.in_distribution and upright.score > CLOSE * ways[0].score:
        ways.remove(upright)
        ways.insert(0, upright)
    return ways


def stood(cloud: PointCloud, pose: Rotation) -> PointCloud:
    """The cloud, turned."""
    from scipy.spatial.transform import RigidTransform

    return cloud.moved(RigidTransform.from_rotation(pose).as_matrix())
