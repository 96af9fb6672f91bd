"""Recognition of one object: track, segment, fuse, grid, classify."""

from circumspect.recognition.frame_outcome import FrameOutcome
from circumspect.recognition.observer import PipelineObserver
from circumspect.recognition.recognition_pipeline import RecognitionPipeline
from circumspect.recognition.recognition_result import RecognitionResult
from circumspect.recognition.recognition_step import RecognitionStep
from circumspect.recognition.runner import run_pipeline

__all__ = [
    "FrameOutcome",
    "PipelineObserver",
    "RecognitionPipeline",
    "RecognitionResult",
    "RecognitionStep",
    "run_pipeline",
]
