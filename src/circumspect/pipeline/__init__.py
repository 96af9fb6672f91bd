"""The main job: frames in, a named object out."""

from circumspect.pipeline.camera_path import camera_path
from circumspect.pipeline.journey import Journey, PlannedView
from circumspect.pipeline.recognition_pipeline import RecognitionPipeline
from circumspect.pipeline.records import (
    CLASSIFIED,
    NO_DEPTH,
    NO_OBJECT,
    NO_POSE,
    OUT_OF_ORDER,
    TOO_LITTLE,
    TOO_WIDE,
    WRONG_UNIT,
    PipelineObserver,
    RecognitionResult,
    RecognitionStep,
)
from circumspect.pipeline.run_folder import RunFolder
from circumspect.pipeline.scan import ObjectScan
from circumspect.pipeline.scan_settings import ScanSettings
from circumspect.pipeline.view_record import ViewRecord

__all__ = [
    "CLASSIFIED",
    "NO_DEPTH",
    "NO_OBJECT",
    "NO_POSE",
    "OUT_OF_ORDER",
    "TOO_LITTLE",
    "TOO_WIDE",
    "WRONG_UNIT",
    "Journey",
    "ObjectScan",
    "PipelineObserver",
    "PlannedView",
    "RecognitionPipeline",
    "RecognitionResult",
    "RecognitionStep",
    "RunFolder",
    "ScanSettings",
    "ViewRecord",
    "camera_path",
]
