"""The recognition node: subscribes to a robot, models and classifies the object, publishes."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

from circumspect.classification import Classifier, Prediction
from circumspect.errors import CircumspectError, InputError
from circumspect.planning import NextView
from circumspect.recognition import FrameOutcome, RecognitionPipeline, RecognitionStep
from circumspect.ros.health import Health, Status
from circumspect.ros.live_frames import LiveFrames
from circumspect.ros.middleware import COMMANDS, Middleware
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.output_messages import EMPTY
from circumspect.ros.result_publisher import ResultPublisher
from circumspect.sensing import BoxSegmentation, GroundSegmentation, RgbdFrame
from circumspect.tracking import KnownPoses, PoseEstimator, Tracker, TrackingSettings

START, STOP, RESET = "start", "stop", "reset"
REPORT_INTERVAL_S = 1.0
"""Interval of diagnostics [s]."""
MAX_COMMANDS = 16
INTERNAL_ERROR = "internal error; see the log"

_log = logging.getLogger(__name__)


class NodeObserver(Protocol):
    """Observer of a node, such as a terminal."""

    def on_step(self, step: RecognitionStep) -> None:
        """Called after each processed frame."""

    def on_finalised(self, prediction: Prediction) -> None:
        """Called with the final prediction while no more frames arrive."""

    def on_status(self, status: Status) -> None:
        """Called after a status was published."""

    def on_command(self, command: str) -> None:
        """Called when the node was started, stopped or reset, by a command or by itself."""


class RecognitionNode:
    """Computes predictions from a robot's messages, in the thread that calls `work`.

    Attributes:
        settings: Parameters.
        observers: Observers of the node.
        health: Counters and status.
        frame: The last processed frame.
    """

    def __init__(
        self,
        middleware: Middleware,
        settings: NodeSettings,
        classifier: Classifier,
        observers: tuple[NodeObserver, ...] = (),
    ) -> None:
        """Subscribe and advertise; with `autostart`, frames are processed from now on.

        Args:
            middleware: Transport of the messages; `close` closes it.
            settings: Parameters.
            classifier: Classifier of the object.
            observers: Observers of the node.

        Raises:
            InputError: A parameter is invalid, or the middleware rejects a topic.
        """
        self.settings, self.observers = settings, observers
        self.health = Health()
        self.frame: RgbdFrame | None = None
        self._middleware, self._classifier = middleware, classifier
        self._pipeline = self._new_pipeline()
        self._publisher = ResultPublisher(middleware, settings)
        self._frames = LiveFrames(middleware, settings, self.health)
        self._backward_jumps = 0
        self._commands: deque[str] = deque(maxlen=MAX_COMMANDS)
        for command in (START, STOP, RESET):
            middleware.subscribe(
                f"{settings.node}/{command}", EMPTY, COMMANDS, self._command_callback(command)
            )
        self._closing = threading.Event()
        self._reporter = threading.Thread(target=self._report, name="diagnostics", daemon=True)
        self._frames.taking = settings.autostart
        self._reporter.start()

    @property
    def running(self) -> bool:
        """Whether frames are processed."""
        return self._frames.taking

    @property
    def target(self) -> NextView | None:
        """The last recommended view."""
        return self._publisher.next_view

    @property
    def ended(self) -> str | None:
        """Why no frames are processed; None while they are."""
        return None if self.running else "the node is stopped"

    def command(self, command: str) -> None:
        """Schedule a command (start, stop or reset); thread-safe.

        Raises:
            InputError: The command is unknown.
        """
        if command not in (START, STOP, RESET):
            raise InputError(f"no command {command!r}; known: {START}, {STOP}, {RESET}")
        self._commands.append(command)

    def spin(self, is_running: Callable[[], bool] = lambda: True) -> None:
        """Work while `is_running` returns true."""
        while is_running():
            self.work()

    def work(self, timeout: float = 0.1) -> RecognitionStep | None:
        """Execute pending commands, then process a frame if there is one.

        Args:
            timeout: Maximum time to wait for a frame [s].
        """
        while self._commands:
            self._execute(self._commands.popleft())
        if self._frames.backward_jumps != self._backward_jumps:
            self._backward_jumps = self._frames.backward_jumps
            _log.warning("the clock was set back: starting a new model")
            self._reset()
            self._notify(RESET)
        frame = self._frames.take(timeout)
        return None if frame is None else self._step(frame)

    def close(self) -> None:
        """Finalise the model, publish the last answer and leave the network."""
        self._closing.set()
        self._reporter.join()
        if self.running:
            self._execute(STOP)
        self._middleware.close()

    def _new_pipeline(self) -> RecognitionPipeline:
        s = self.settings
        tracker: PoseEstimator = KnownPoses()
        if s.poses == "found":
            tracker = Tracker(settings=TrackingSettings.for_noise(s.noise))
        segmentation = GroundSegmentation(noise=s.noise)
        if s.box:
            segmentation = BoxSegmentation(s.box[:3], s.box[3:], s.noise)
        return RecognitionPipeline(segmentation, tracker, self._classifier)

    def _step(self, frame: RgbdFrame) -> RecognitionStep | None:
        start = time.perf_counter()
        self.frame = frame
        try:
            step = self._pipeline.step(frame)
            self._publisher.step(step, frame, self._pipeline.tracker, self._frames.odom_frame)
        except CircumspectError as error:
            self._failed(str(error))
            return None
        except Exception:  # one frame must not stop the node
            _log.exception("a frame could not be processed")
            self._failed(INTERNAL_ERROR)
            return None
        spent = 1e3 * (time.perf_counter() - start)
        if step.outcome != FrameOutcome.CLASSIFIED:
            _log.warning("a frame did not change the model: %s", step.outcome)
        if step.pose is not None and not step.pose.reliable:
            _log.warning("pose not reliable: %s", step.pose.reason)
        self.health.on_step(step, spent)
        for observer in self.observers:
            observer.on_step(step)
        return step

    def _failed(self, reason: str) -> None:
        self.health.report_error(reason)
        _log.warning("frame skipped: %s", reason)

    def _command_callback(self, command: str) -> Callable[[bytes], None]:
        def on_message(_: bytes) -> None:
            self.command(command)

        return on_message

    def _execute(self, command: str) -> None:
        if command == START:
            self._frames.taking = True
        elif command == STOP:
            self._frames.taking = False
            self._frames.clear()
            self._finalise()
        else:
            self._frames.clear()
            self._reset()
        self._notify(command)

    def _notify(self, command: str) -> None:
        for observer in self.observers:
            observer.on_command(command)

    def _reset(self) -> None:
        self._pipeline = self._new_pipeline()
        self._publisher.reset()
        self.health.reset()

    def _finalise(self) -> None:
        """Finalise the model and publish the final answer."""
        try:
            self._pipeline.finalise()
            self._publisher.finalised(self._pipeline)
            if (prediction := self._pipeline.prediction) is not None:
                self.health.on_finalised(prediction)
                for observer in self.observers:
                    observer.on_finalised(prediction)
        except Exception:  # an error must not keep the node from stopping
            _log.exception("the model could not be finalised")
            self.health.report_error(INTERNAL_ERROR)

    def _report(self) -> None:
        while not self._closing.wait(REPORT_INTERVAL_S):
            try:
                if error := self._frames.odometry_error():
                    self.health.report_error(error)
                    _log.warning("%s", error)
                status = self.health.status(
                    self.running, self._frames.missing(), self._middleware.lost
                )
                self._publisher.status(status)
                for observer in self.observers:
                    observer.on_status(status)
            except Exception:  # diagnostics must continue
                _log.exception("the diagnostics could not be published")
