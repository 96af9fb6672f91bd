"""A box on a floor, seen by a small camera: frames enough for a pipeline, and fast."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import numpy as np
from volume_classifier import VolumeClassifier

from circumspect.geometry import PinholeCamera
from circumspect.recognition import (
    PipelineObserver,
    RecognitionPipeline,
    RecognitionResult,
    RecognitionStep,
    run_pipeline,
)
from circumspect.recognition.background_worker import BackgroundWorker
from circumspect.sensing import DepthNoise, GroundSegmentation, RgbdFrame
from circumspect.simulation import Orbit, Scene, SimulatedCamera, block
from circumspect.tracking import KnownPoses

CAMERA = PinholeCamera(320, 240, 285.0, 285.0, 159.5, 119.5)
BOX = block((-0.25, -0.35, 0.0), (0.25, 0.35, 0.6))


def frames(count: int, start: float = 0.3) -> Iterator[RgbdFrame]:
    orbit = Orbit.around(BOX, CAMERA, start=start)
    stations = orbit.stations(max(count, 1))
    scene = Scene.with_object(BOX)
    return SimulatedCamera(scene, stations.__next__, CAMERA, DepthNoise(), 0).frames(count)


def make_pipeline(classifier: VolumeClassifier | None = None) -> RecognitionPipeline:
    return RecognitionPipeline(GroundSegmentation(), KnownPoses(), classifier or VolumeClassifier())


def run(frames: Iterable[RgbdFrame], *observers: PipelineObserver) -> RecognitionResult:
    """The result of a new pipeline on these frames."""
    return run_pipeline(make_pipeline(), frames, observers)


def blind(frame: RgbdFrame) -> RgbdFrame:
    return RgbdFrame(
        np.full(frame.depth.shape, np.nan), frame.camera, frame.stamp, frame.T_map_camera
    )


class Inline(BackgroundWorker):
    """Runs each call at once."""

    def submit(self, work: Callable[[], None]) -> None:
        work()


class StepRecorder:
    """Keeps the steps and results that an observer receives."""

    def __init__(self) -> None:
        self.steps: list[RecognitionStep] = []
        self.ends: list[RecognitionResult] = []

    def on_step(self, step: RecognitionStep) -> None:
        self.steps.append(step)

    def on_end(self, result: RecognitionResult) -> None:
        self.ends.append(result)
