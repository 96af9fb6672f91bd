"""The node: hears a robot, models and names what stands before it, and tells."""

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
from circumspect.ros.announcer import Announcer
from circumspect.ros.health import Health, Status
from circumspect.ros.live_frames import LiveFrames
from circumspect.ros.middleware import COMMANDS, Middleware
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.outgoing import EMPTY
from circumspect.sensing import BoxSegmentation, GroundSegmentation, RgbdFrame
from circumspect.tracking import KnownPoses, PoseEstimator, Tracker, TrackingSettings

START, STOP, RESET = "start", "stop", "reset"
REPORT_EVERY = 1.0
"""Between two diagnostics [s]."""
MOST_COMMANDS = 16
FAULT = "a fault inside; see the log"

_log = logging.getLogger(__name__)


class NodeObserver(Protocol):
    """Watches a node: a terminal."""

    def on_step(self, step: RecognitionStep) -> None:
        """A frame went through."""

    def on_settled(self, prediction: Prediction) -> None:
        """No more frames come for now: the answer by all that is known."""

    def on_status(self, status: Status) -> None:
        """A status was published."""

    def on_command(self, command: str) -> None:
        """Somebody told the node to start, stop or reset, or it did so by itself."""


class RecognitionNode:
    """Turns the messages of a robot into answers; works in the thread that calls `work`.

    Attributes:
        settings: Parameters.
        observers: Are told what happens.
        health: What came, what was left out.
        frame: The latest one that was worked on.
    """

    def __init__(
        self,
        middleware: Middleware,
        settings: NodeSettings,
        classifier: Classifier,
        observers: tuple[NodeObserver, ...] = (),
    ) -> None:
        """Subscribe and advertise; with `autostart` frames are taken from now on.

        Args:
            middleware: Carries the messages; is closed by `close`.
            settings: Parameters.
            classifier: Names the object.
            observers: Are told what happens.

        Raises:
            InputError: A parameter makes no sense, or the middleware refuses a topic.
        """
        self.settings, self.observers = settings, observers
        self.health = Health()
        self.frame: RgbdFrame | None = None
        self._middleware, self._classifier = middleware, classifier
        self._pipeline = self._new_pipeline()
        self._announcer = Announcer(middleware, settings)
        self._frames = LiveFrames(middleware, settings, self.health)
        self._leaps_back = 0
        self._commands: deque[str] = deque(maxlen=MOST_COMMANDS)
        for command in (START, STOP, RESET):
            middleware.subscribe(
                f"{settings.node}/{command}", EMPTY, COMMANDS, self._commander(command)
            )
        self._closing = threading.Event()
        self._reporter = threading.Thread(target=self._report, name="diagnostics", daemon=True)
        self._frames.taking = settings.autostart
        self._reporter.start()

    @property
    def running(self) -> bool:
        """Whether frames are taken."""
        return self._frames.taking

    @property
    def target(self) -> NextView | None:
        """The view that was advised last."""
        return self._announcer.advised

    @property
    def ended(self) -> str | None:
        """Why no frames are taken; None while they are."""
        return None if self.running else "the node is stopped"

    def command(self, command: str) -> None:
        """Have the node start, stop or reset, soon; may be called from any thread.

        Raises:
            InputError: It knows no such command.
        """
        if command not in (START, STOP, RESET):
            raise InputError(f"no command {command!r}; known: {START}, {STOP}, {RESET}")
        self._commands.append(command)

    def spin(self, going_on: Callable[[], bool] = lambda: True) -> None:
        """Work as long as that is wanted."""
        while going_on():
            self.work()

    def work(self, timeout: float = 0.1) -> RecognitionStep | None:
        """Obey the commands that came, then take one frame, where there is one.

        Args:
            timeout: So long a frame is waited for [s].
        """
        while self._commands:
            self._obey(self._commands.popleft())
        if self._frames.leaps_back != self._leaps_back:
            self._leaps_back = self._frames.leaps_back
            _log.warning("the clock was set back: the object is modelled anew")
            self._begin_anew()
            self._tell(RESET)
        frame = self._frames.take(timeout)
        return None if frame is None else self._step(frame)

    def close(self) -> None:
        """End the run: settle, tell the last answer, leave the network."""
        self._closing.set()
        self._reporter.join()
        if self.running:
            self._obey(STOP)
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
            self._announcer.step(step, frame, self._pipeline.tracker, self._frames.odom_frame)
        except CircumspectError as error:
            self._failed(str(error))
            return None
        except Exception:  # one frame must not end the node
            _log.exception("a frame could not be worked on")
            self._failed(FAULT)
            return None
        spent = 1e3 * (time.perf_counter() - start)
        if step.outcome != FrameOutcome.CLASSIFIED:
            _log.warning("a frame left the model as it was: %s", step.outcome)
        if step.pose is not None and not step.pose.reliable:
            _log.warning("pose not reliable: %s", step.pose.reason)
        self.health.step(step, spent)
        for observer in self.observers:
            observer.on_step(step)
        return step

    def _failed(self, reason: str) -> None:
        self.health.fault(reason)
        _log.warning("a frame left out: %s", reason)

    def _commander(self, command: str) -> Callable[[bytes], None]:
        def heard(_: bytes) -> None:
            self.command(command)

        return heard

    def _obey(self, command: str) -> None:
        if command == START:
            self._frames.taking = True
        elif command == STOP:
            self._frames.taking = False
            self._frames.clear()
            self._settle()
        else:
            self._frames.clear()
            self._begin_anew()
        self._tell(command)

    def _tell(self, command: str) -> None:
        for observer in self.observers:
            observer.on_command(command)

    def _begin_anew(self) -> None:
        self._pipeline = self._new_pipeline()
        self._announcer.reset()
        self.health.forget_answer()

    def _settle(self) -> None:
        """Tell what is known when no more frames come for now."""
        try:
            self._pipeline.finalise()
            self._announcer.settled(self._pipeline)
            if (prediction := self._pipeline.prediction) is not None:
                self.health.settled(prediction)
                for observer in self.observers:
                    observer.on_settled(prediction)
        except Exception:  # a fault here must not keep the node from stopping
            _log.exception("the model could not be settled")
            self.health.fault(FAULT)

    def _report(self) -> None:
        while not self._closing.wait(REPORT_EVERY):
            try:
                if fault := self._frames.odometry_fault():
                    self.health.fault(fault)
                    _log.warning("%s", fault)
                status = self.health.status(
                    self.running, self._frames.missing(), self._middleware.lost
                )
                self._announcer.status(status)
                for observer in self.observers:
                    observer.on_status(status)
            except Exception:  # diagnostics must go on
                _log.exception("the diagnostics could not be told")
