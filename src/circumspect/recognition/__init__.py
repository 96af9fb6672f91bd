"""Recognition of one object: track, segment, fuse, grid, classify."""

from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.recognition.recognition_pipeline import RecognitionPipeline
from circumspect.recognition.recognition_step import RecognitionResult, RecognitionStep
from circumspect.recognition.runner import PipelineObserver, run_pipeline

__all__ = [
    "FrameOutcome",
    "PipelineObserver",
    "RecognitionPipeline",
    "RecognitionResult",
    "RecognitionStep",
    "run_pipeline",
]
