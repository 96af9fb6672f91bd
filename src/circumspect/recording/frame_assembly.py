"""Frames, put together of messages."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterable, Iterator, MutableMapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import CircumspectError, InputError
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.recording.bag import BagMessage
from circumspect.recording.bag_preview import LASTING
from circumspect.recording.clock_comparison import ClockComparison
from circumspect.recording.image_messages import camera_of, colour_of, depth_of, is_distorted
from circumspect.recording.odometry_buffer import OdometryBuffer
from circumspect.recording.pose_messages import odometry_of, transform_of
from circumspect.recording.repeated_warnings import RepeatedWarnings
from circumspect.recording.ros_time import NANOSECONDS, seconds
from circumspect.recording.topic_choice import ChosenTopics
from circumspect.recording.transform_tree import TransformTree, plain
from circumspect.sensing import Odometry, RgbdFrame

PATIENCE = 0.5
"""So long [s] a frame waits for odometry that is later than it, and for its colour."""
TOGETHER = 0.02
"""A colour image belongs to a depth image if their stamps differ by no more than this [s]."""
COLOURS = 8
"""So many of the last colour images are kept."""
WITHOUT_CAMERA = 30
"""So many depth images wait for the first CameraInfo."""
LEAP, BACK = 5.0, 1.0
"""From image to image stamps gain no more than this on the clock by which they are heard, and fall
by no more than that [s]. They may lose any time: a source that was paused goes on where it was."""
MOST_WAITING = 100
"""So many depth images wait at most, whatever the clocks say."""
MOST_KEPT = 256 << 20
"""So many bytes of depth images wait at most, and half as many of colour images are kept."""

_log = logging.getLogger(__name__)


_Moment: TypeAlias = tuple[float, float]
"""Stamp [s] of an image, and when it was heard [s]."""


class ClockError(InputError):
    """From here on the stamps belong to another time.

    Attributes:
        leap: How far the clock leapt [s]; negative is back.
    """

    def __init__(self, leap: float, stamp: float) -> None:
        super().__init__(
            f"the clock leapt by {leap:+.1f} s at {stamp:.3f} s; what follows is left out"
        )
        self.leap = leap


@dataclass(frozen=True)
class AssemblySettings:
    """What messages do not tell.

    Attributes:
        camera: Instead of CameraInfo.
        T_base_camera: Instead of transforms.
        map_frame: Frames bring their pose in it, where transforms tell it; None for none.
        synchronous: The odometry before a depth image, since the last one, is that image's own.
        odom_frame: Where no topic holds odometry, transforms from here to the base are taken as
            it; None for none.
        base_frame: The robot's, where odometry does not tell it.
        depth_scale: Metres a unit of the depth images; None for those of their encoding.
    """

    camera: PinholeCamera | None = None
    T_base_camera: RigidTransform | None = None
    map_frame: str | None = None
    synchronous: bool = False
    odom_frame: str | None = None
    base_frame: str = "base_link"
    depth_scale: float | None = None


class FrameAssembly:
    """Takes messages in the order in which they were heard, and gives frames.

    Attributes:
        skipped: Name of a frame to why it was left out.
        unread: Topic to why its last message that could not be used was left out.
        odom_frame: That of the odometry, by its messages or else by the settings; None as long as
            neither tells it.
    """

    def __init__(
        self,
        topics: ChosenTopics,
        settings: AssemblySettings,
        left_out: MutableMapping[str, str] | None = None,
    ) -> None:
        """Begin with nothing heard.

        Args:
            topics: What is on which topic.
            settings: What messages do not tell.
            left_out: Takes down frames and messages that are left out, where they are many: a
                dictionary would grow with the time.
        """
        self.skipped: MutableMapping[str, str] = {} if left_out is None else left_out
        self.unread: MutableMapping[str, str] = {} if left_out is None else left_out
        self._topics, self._settings = topics, settings
        self._camera = settings.camera
        self._tree = TransformTree()
        self._buffer = OdometryBuffer()
        self._since_image: Odometry | None = None
        self.odom_frame = settings.odom_frame
        self._base = settings.base_frame
        self._colours: deque[Any] = deque(maxlen=COLOURS)
        self._waiting: deque[tuple[BagMessage, Odometry | None]] = deque()
        self._clock: _Moment | None = None
        self._strange: _Moment | None = None
        """Of the last image, where its stamp leapt."""
        self._count = 0
        self._clocks = ClockComparison()
        self._info_fault = ""
        """Why the last CameraInfo can not be used."""
        self._warnings = RepeatedWarnings(_log)

    def begin_with(self, info: Any, static: Sequence[Any]) -> None:
        """Take in what holds from the beginning, although its messages come later.

        Args:
            info: A CameraInfo, or None.
            static: Transforms that hold until another is told.
        """
        if info is not None and self._settings.camera is None:
            self._learn_camera(info)
        for stamped in static:
            try:
                self._tree.hold(stamped)
            except CircumspectError as error:
                self._warnings.warn(f"a static transform left out: {error}")

    @property
    def known_frames(self) -> set[str]:
        """The names of all frames that transforms told of so far."""
        return self._tree.frames

    def heard(self, message: BagMessage) -> Iterator[RgbdFrame]:
        """Take a message in; give the frames that are complete with it.

        Raises:
            ClockError: The stamps of two images in a row leapt to the same time; nothing from this
                message on can be used, unless after `restart`. A single image is left out.
            InputError: No CameraInfo comes.
        """
        topics, told = self._topics, message.told
        try:
            if message.topic == topics.info and self._settings.camera is None:
                self._learn_camera(told)
            elif message.topic in topics.transforms:
                self._tree.heard(told, lasting=message.topic.endswith(LASTING))
                self._hear_moving_base(told, message.log_time)
            elif message.topic == topics.odometry:
                self._hear_odometry(told, message.log_time)
            elif message.topic == topics.colour:
                self._colours.append(told)
                while len(self._colours) > 1 and _size(self._colours) > MOST_KEPT // 2:
                    self._colours.popleft()
        except CircumspectError as error:
            self.unread[message.topic] = str(error)
            if message.topic == topics.info:
                self._info_fault = str(error)
            self._warnings.warn(f"a message on {message.topic} left out: {error}")
        if message.topic == topics.depth:
            self._wait(message)
        yield from self._complete(message.log_time)

    def restart(self) -> None:
        """Forget what belongs to the time before a leap; the camera and what stands still stay."""
        self._buffer, self._since_image = OdometryBuffer(), None
        self._clocks = ClockComparison()
        self._clock = self._strange = None
        self._colours.clear()
        self.let_go()
        self._tree.begin_anew()

    def let_go(self) -> None:
        """Drop the images that wait: nobody wants their frames any more."""
        self._waiting.clear()

    def rest(self) -> Iterator[RgbdFrame]:
        """The frames that still wait when no more messages come."""
        while self._waiting:
            yield from self._next()
        self._warnings.log_counts()

    def _hear_odometry(self, told: Any, log_time: int) -> None:
        self._base = told.child_frame_id or self._base
        self._since_image = odometry_of(told)
        self._buffer.heard(self._since_image)
        self._clocks.on_odometry(self._since_image.stamp, log_time / NANOSECONDS)
        self.odom_frame = plain(told.header.frame_id) or self.odom_frame

    def _hear_moving_base(self, told: Any, log_time: int) -> None:
        """Take transforms for odometry where no topic holds it."""
        odom = self._settings.odom_frame
        if odom is None or self._topics.odometry is not None:
            return
        for stamped in told.transforms:
            ends = plain(stamped.header.frame_id), plain(stamped.child_frame_id)
            if ends == (odom, self._base):
                moved = stamped.transform
                T_odom_base = transform_of(moved.translation, moved.rotation)
                pose = PlanarPose.from_transform(T_odom_base)
                self._buffer.heard(Odometry(seconds(stamped), pose))
                self._clocks.on_odometry(seconds(stamped), log_time / NANOSECONDS)

    def _learn_camera(self, info: Any) -> None:
        if self._camera is None and is_distorted(info):
            _log.warning("the CameraInfo tells of distortion; depth images are taken as rectified")
        self._camera, self._info_fault = camera_of(info), ""

    def _wait(self, message: BagMessage) -> None:
        now = seconds(message.told), message.log_time / NANOSECONDS
        if leap := _leap(self._clock, now):
            if self._strange is not None and not _leap(self._strange, now):
                raise ClockError(leap, now[0])
            self._strange, self._since_image = now, None
            self._count += 1
            self.skipped[f"frame {self._count} at {now[0]:.3f} s"] = (
                f"its stamp is {leap:+.1f} s off"
            )
            return
        self._clock, self._strange = now, None
        self._waiting.append((message, self._since_image))
        self._since_image = None
        if self._camera is None and (
            len(self._waiting) > WITHOUT_CAMERA or self._waiting_size() > MOST_KEPT
        ):
            self._waiting.popleft()
            raise InputError(f"{self._no_camera()}, or give --intrinsics FX FY CX CY")

    def _no_camera(self) -> str:
        """Why there are no intrinsics, and the remedy."""
        named = "name another topic (replay --info-topic, ros2 --info)"
        if self._info_fault:
            return f"{self._topics.info}: {self._info_fault}; {named}"
        return f"no CameraInfo comes with {self._topics.depth}; {named}"

    def _complete(self, log_time: int) -> Iterator[RgbdFrame]:
        while self._waiting and self._camera is not None:
            message = self._waiting[0][0]
            waited = log_time - message.log_time
            patient = 0 <= waited < PATIENCE * NANOSECONDS and len(self._waiting) < MOST_WAITING
            if patient and self._waiting_size() <= MOST_KEPT and self._more_to_come(message.told):
                return
            yield from self._next()

    def _waiting_size(self) -> int:
        return _size(message.told for message, _ in self._waiting)

    def _more_to_come(self, image: Any) -> bool:
        """Whether poses, odometry or colour of an image's time may still be on the way."""
        if self._settings.synchronous:
            return False
        stamp = seconds(image)
        target = self._settings.map_frame or self._base
        if self._tree.awaits(target, image.header.frame_id, stamp):
            return True
        expected = self._topics.odometry is not None or self._settings.odom_frame is not None
        if expected and not self._buffer.reaches(stamp):
            return True
        if self._topics.colour is None:
            return False
        return not any(seconds(image) >= stamp - TOGETHER for image in self._colours)

    def _next(self) -> Iterator[RgbdFrame]:
        """The frame that has waited longest, unless it is broken."""
        message, own = self._waiting.popleft()
        self._count += 1
        try:
            frame = self._frame(message.told, own)
            self._compare_clocks(frame, message.log_time)
            yield frame
        except CircumspectError as error:
            self.skipped[f"frame {self._count} at {seconds(message.told):.3f} s"] = str(error)
            self._warnings.warn(f"frame {self._count} left out: {error}")

    def _compare_clocks(self, frame: RgbdFrame, log_time: int) -> None:
        was_known = self._clocks.warning
        warning = self._clocks.on_image(
            frame.stamp, log_time / NANOSECONDS, frame.odometry is not None
        )
        if warning:
            self.skipped["odometry"] = warning
        if warning and not was_known:
            _log.warning("%s; frames have no odometry", warning)

    def _frame(self, image: Any, own: Odometry | None) -> RgbdFrame:
        settings, stamp, camera = self._settings, seconds(image), self._camera
        if camera is None:
            raise InputError(self._no_camera())
        depth = depth_of(image, settings.depth_scale)
        if depth.shape != (camera.height, camera.width):
            raise InputError(
                f"the depth has {depth.shape[1]} x {depth.shape[0]} pixels, the CameraInfo tells "
                f"of {camera.width} x {camera.height}"
            )
        optical = image.header.frame_id
        mount = settings.T_base_camera
        if mount is None:
            mount = self._tree.between(self._base, optical, stamp)
        pose = None
        if settings.map_frame is not None:
            pose = self._tree.between(settings.map_frame, optical, stamp)
        odometry = own if settings.synchronous else self._buffer.at(stamp)
        colour = self._colour_at(stamp, depth)
        return RgbdFrame(depth, camera, stamp, pose, colour, odometry, mount)

    def _colour_at(self, stamp: float, depth: NDArray[np.float32]) -> NDArray[np.uint8] | None:
        """The colour image nearest in time, if it lies on the depth."""
        nearest = min(self._colours, key=lambda image: abs(seconds(image) - stamp), default=None)
        if nearest is None or abs(seconds(nearest) - stamp) > TOGETHER:
            return None
        if (nearest.height, nearest.width) != depth.shape:
            return None
        try:
            return colour_of(nearest)
        except InputError as error:
            self._warnings.warn(f"colour left out: {error}")
            return None


def _size(images: Iterable[Any]) -> int:
    """Of their pixels [bytes]."""
    return sum(len(image.data) for image in images)


def _leap(before: _Moment | None, now: _Moment) -> float:
    """How far the clock leapt from one image to another [s]; 0 where it did not."""
    if before is None:
        return 0.0
    step, waited = now[0] - before[0], now[1] - before[1]
    if step < -BACK:
        return step
    return step - waited if step > waited + LEAP else 0.0
