"""Recognition of one object: track, segment, fuse, grid, classify."""

from circumspect.recognition.recognition_pipeline import RecognitionPipeline
from circumspect.recognition.recognition_step import (
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

__all__ = [
    "CLASSIFIED",
    "NO_DEPTH",
    "NO_OBJECT",
    "NO_POSE",
    "OUT_OF_ORDER",
    "TOO_LITTLE",
    "TOO_WIDE",
    "WRONG_UNIT",
    "PipelineObserver",
    "RecognitionPipeline",
    "RecognitionResult",
    "RecognitionStep",
]
