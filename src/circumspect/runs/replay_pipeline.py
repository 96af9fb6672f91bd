"""The recognition pipeline for a recording."""

from __future__ import annotations

from scipy.spatial.transform import RigidTransform

from circumspect.classification import Classifier
from circumspect.errors import InputError
from circumspect.recognition import RecognitionPipeline
from circumspect.recording import Recording
from circumspect.sensing import DepthNoise, GroundSegmentation, Segmentation
from circumspect.tracking import KnownPoses, PoseEstimator, Tracker, TrackingSettings


def replay_pipeline(
    recording: Recording,
    classifier: Classifier,
    segmentation: Segmentation | None = None,
    hidden: bool = True,
    T_map_first: RigidTransform | None = None,
    noise: DepthNoise | None = None,
) -> RecognitionPipeline:
    """Create the pipeline of a live run on the same frames.

    Args:
        recording: The recording.
        classifier: Classifies the object.
        segmentation: Finds the object; None means the object on the floor in front of the robot.
        hidden: Whether poses are tracked; else the recorded ones are taken as true.
        T_map_first: Pose of the first frame, above a floor at z = 0; None means the recorded one.
        noise: The camera's noise and range; None means the Xtion PRO's.

    Raises:
        InputError: The pose of the floor is unknown.
    """
    noise = noise or DepthNoise()
    if segmentation is None:
        if not recording.has_floor and T_map_first is None:
            raise InputError(
                f"{recording.path}: the floor is unknown; give the object's --box "
                "X Y Z X Y Z, or --first-pose X Y Z PAN TILT"
            )
        segmentation = GroundSegmentation(noise=noise)
    tracker: PoseEstimator = KnownPoses()
    if hidden:
        tracker = Tracker(T_map_first, TrackingSettings.for_noise(noise))
    return RecognitionPipeline(segmentation, tracker, classifier)
