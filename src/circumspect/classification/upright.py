"""Names objects of which nobody knows which way is up."""

from __future__ import annotations

from typing import TYPE_CHECKING

from circumspect.classification.classifier import Classifier
from circumspect.classification.prediction import Prediction
from circumspect.geometry import PointCloud

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def classify_any_way_up(
    classifier: Classifier, cloud: PointCloud, *, metric: bool = False
) -> tuple[Prediction, Rotation]:
    """Stand an object on each face that it can stand on, and take the most probable answer.

    Args:
        classifier: Names standing objects.
        cloud: The object's surface, any axis up.
        metric: The points are in metres; without it their scale counts as unknown.

    Returns:
        The answer, and the rotation from the cloud's coordinates to those of the standing object.

    Raises:
        GeometryError: The points span no shape.
    """
    # SciPy's part for space takes as long to load as all else that names a standing object.
    from circumspect.geometry.resting_poses import resting_poses

    answers = [
        (classifier.classify(stood(cloud, pose), metric=metric), pose)
        for pose in resting_poses(cloud)
    ]
    return max(answers, key=lambda answer: answer[0].probability)


def stood(cloud: PointCloud, pose: Rotation) -> PointCloud:
    """The cloud, turned."""
    from scipy.spatial.transform import RigidTransform

    return cloud.moved(RigidTransform.from_rotation(pose).as_matrix())
