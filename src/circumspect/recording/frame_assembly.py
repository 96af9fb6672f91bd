"""Assembly of RGB-D frames from ROS messages."""

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
from circumspect.recording.bag_preview import STATIC_SUFFIX
from circumspect.recording.image_messages import camera_of, colour_of, depth_of, is_distorted
from circumspect.recording.message_clocks import ClockComparison
from circumspect.recording.odometry_buffer import OdometryBuffer
from circumspect.recording.pose_messages import odometry_of, transform_of
from circumspect.recording.repeated_warnings import RepeatedWarnings
from circumspect.recording.ros_time import NANOSECONDS, seconds
from circumspect.recording.topic_choice import ChosenTopics
from circumspect.recording.transform_tree import TransformTree, plain
from circumspect.sensing import Odometry, RgbdFrame

MAX_WAIT_S = 0.5
"""Maximum time that a frame waits for later odometry and for its colour image [s]."""
MAX_COLOUR_OFFSET_S = 0.02
"""Maximum difference between the stamps of a depth image and its colour image [s]."""
MAX_COLOUR_IMAGES = 8
"""Number of recent colour images that are kept."""
MAX_IMAGES_WITHOUT_CAMERA = 30
"""Maximum number of depth images that wait for the first CameraInfo."""
MAX_FORWARD_JUMP_S, MAX_BACKWARD_JUMP_S = 5.0, 1.0
"""Maximum gain and loss of image stamps against the receiving clock between two images [s].

Stamps may fall behind by any time: a paused source resumes with the stamps where it stopped."""
MAX_PENDING_IMAGES = 100
"""Maximum number of waiting depth images."""
MAX_PENDING_BYTES = 256 << 20
"""Maximum size of the waiting depth images [bytes]; half of it for colour images."""

_log = logging.getLogger(__name__)


_ImageTimes: TypeAlias = tuple[float, float]
"""Stamp of an image and time at which it was received [s]."""


class ClockError(InputError):
    """The stamps jumped to another time.

    Attributes:
        jump_s: Size of the jump [s]; negative is backwards.
    """

    def __init__(self, jump_s: float, stamp: float) -> None:
        super().__init__(
            f"the clock jumped by {jump_s:+.1f} s at {stamp:.3f} s; later messages are skipped"
        )
        self.jump_s = jump_s


@dataclass(frozen=True)
class AssemblySettings:
    """Settings of `FrameAssembly`.

    Attributes:
        camera: Intrinsics to use instead of CameraInfo.
        T_base_camera: Mount to use instead of transforms.
        map_frame: Frame of the poses that frames carry, if transforms give them; None for no poses.
        synchronous: The odometry between two depth images belongs to the later one.
        odom_frame: If no topic has odometry, transforms from this frame to the base are used; None
            for no odometry.
        base_frame: Frame of the robot if odometry does not name it.
        depth_scale: Metres per unit of the depth images; None for the default of their encoding.
    """

    camera: PinholeCamera | None = None
    T_base_camera: RigidTransform | None = None
    map_frame: str | None = None
    synchronous: bool = False
    odom_frame: str | None = None
    base_frame: str = "base_link"
    depth_scale: float | None = None


class FrameAssembly:
    """Assembles frames from messages in the order they were received.

    Attributes:
        skipped: Skipped frames, with the reason.
        unread: Topics with unusable messages, with the reason of the last one.
        odom_frame: Frame of the odometry, from its messages or else from the settings; None if
            unknown.
    """

    def __init__(
        self,
        topics: ChosenTopics,
        settings: AssemblySettings,
        left_out: MutableMapping[str, str] | None = None,
    ) -> None:
        """Start without any message.

        Args:
            topics: The chosen topics.
            settings: Settings.
            left_out: Mapping that receives skipped frames and messages, for long runs in which a
                dictionary would grow without bound.
        """
        self.skipped: MutableMapping[str, str] = {} if left_out is None else left_out
        self.unread: MutableMapping[str, str] = {} if left_out is None else left_out
        self._topics, self._settings = topics, settings
        self._camera = settings.camera
        self._tree = TransformTree()
        self._buffer = OdometryBuffer()
        self._odometry_since_image: Odometry | None = None
        self.odom_frame = settings.odom_frame
        self._base = settings.base_frame
        self._colours: deque[Any] = deque(maxlen=MAX_COLOUR_IMAGES)
        self._pending: deque[tuple[BagMessage, Odometry | None]] = deque()
        self._clock: _ImageTimes | None = None
        self._outlier: _ImageTimes | None = None
        """Times of the last image if its stamp jumped."""
        self._count = 0
        self._clocks = ClockComparison()
        self._info_error = ""
        """Why the last CameraInfo is unusable."""
        self._warnings = RepeatedWarnings(_log)

    def begin_with(self, info: Any, static: Sequence[Any]) -> None:
        """Add data that hold from the start, although their messages come later.

        Args:
            info: A CameraInfo, or None.
            static: Static transforms.
        """
        if info is not None and self._settings.camera is None:
            self._set_camera(info)
        for stamped in static:
            try:
                self._tree.add_static(stamped)
            except CircumspectError as error:
                self._warnings.warn(f"static transform skipped: {error}")

    @property
    def known_frames(self) -> set[str]:
        """Names of all frames in the transforms received so far."""
        return self._tree.frames

    def on_message(self, message: BagMessage) -> Iterator[RgbdFrame]:
        """Process a message and yield the frames that it completes.

        Raises:
            ClockError: The stamps of two successive images jumped to the same time. No later
                message is usable until `restart`; a single image is skipped instead.
            InputError: No CameraInfo arrives.
        """
        topics, msg = self._topics, message.msg
        try:
            if message.topic == topics.info and self._settings.camera is None:
                self._set_camera(msg)
            elif message.topic in topics.transforms:
                self._tree.add(msg, static=message.topic.endswith(STATIC_SUFFIX))
                self._on_base_transform(msg, message.log_time)
            elif message.topic == topics.odometry:
                self._on_odometry(msg, message.log_time)
            elif message.topic == topics.colour:
                self._colours.append(msg)
                while len(self._colours) > 1 and _size(self._colours) > MAX_PENDING_BYTES // 2:
                    self._colours.popleft()
        except CircumspectError as error:
            self.unread[message.topic] = str(error)
            if message.topic == topics.info:
                self._info_error = str(error)
            self._warnings.warn(f"message on {message.topic} skipped: {error}")
        if message.topic == topics.depth:
            self._enqueue(message)
        yield from self._complete_frames(message.log_time)

    def restart(self) -> None:
        """Forget data from before a clock jump, except the camera and static transforms."""
        self._buffer, self._odometry_since_image = OdometryBuffer(), None
        self._clocks = ClockComparison()
        self._clock = self._outlier = None
        self._colours.clear()
        self.drop_pending()
        self._tree.reset_clock()

    def drop_pending(self) -> None:
        """Drop the waiting images."""
        self._pending.clear()

    def remaining_frames(self) -> Iterator[RgbdFrame]:
        """The frames still waiting after the last message."""
        while self._pending:
            yield from self._next()
        self._warnings.log_counts()

    def _on_odometry(self, msg: Any, log_time: int) -> None:
        self._base = msg.child_frame_id or self._base
        self._odometry_since_image = odometry_of(msg)
        self._buffer.add(self._odometry_since_image)
        self._clocks.on_odometry(self._odometry_since_image.stamp, log_time / NANOSECONDS)
        self.odom_frame = plain(msg.header.frame_id) or self.odom_frame

    def _on_base_transform(self, msg: Any, log_time: int) -> None:
        """Use transforms as odometry if no topic has it."""
        odom = self._settings.odom_frame
        if odom is None or self._topics.odometry is not None:
            return
        for stamped in msg.transforms:
            ends = plain(stamped.header.frame_id), plain(stamped.child_frame_id)
            if ends == (odom, self._base):
                moved = stamped.transform
                T_odom_base = transform_of(moved.translation, moved.rotation)
                pose = PlanarPose.from_transform(T_odom_base)
                self._buffer.add(Odometry(seconds(stamped), pose))
                self._clocks.on_odometry(seconds(stamped), log_time / NANOSECONDS)

    def _set_camera(self, info: Any) -> None:
        if self._camera is None and is_distorted(info):
            _log.warning("the CameraInfo has distortion; depth images are assumed to be rectified")
        self._camera, self._info_error = camera_of(info), ""

    def _enqueue(self, message: BagMessage) -> None:
        now = seconds(message.msg), message.log_time / NANOSECONDS
        if jump_s := _clock_jump(self._clock, now):
            if self._outlier is not None and not _clock_jump(self._outlier, now):
                raise ClockError(jump_s, now[0])
            self._outlier, self._odometry_since_image = now, None
            self._count += 1
            self.skipped[f"frame {self._count} at {now[0]:.3f} s"] = (
                f"its stamp jumped by {jump_s:+.1f} s"
            )
            return
        self._clock, self._outlier = now, None
        self._pending.append((message, self._odometry_since_image))
        self._odometry_since_image = None
        if self._camera is None and (
            len(self._pending) > MAX_IMAGES_WITHOUT_CAMERA
            or self._pending_bytes() > MAX_PENDING_BYTES
        ):
            self._pending.popleft()
            raise InputError(f"{self._no_camera()}, or give --intrinsics FX FY CX CY")

    def _no_camera(self) -> str:
        """Explanation of missing intrinsics and how to provide them."""
        named = "choose another topic (replay --info-topic, ros2 --info)"
        if self._info_error:
            return f"{self._topics.info}: {self._info_error}; {named}"
        return f"no CameraInfo belongs to {self._topics.depth}; {named}"

    def _complete_frames(self, log_time: int) -> Iterator[RgbdFrame]:
        while self._pending and self._camera is not None:
            message = self._pending[0][0]
            waited = log_time - message.log_time
            may_wait = (
                0 <= waited < MAX_WAIT_S * NANOSECONDS and len(self._pending) < MAX_PENDING_IMAGES
            )
            if (
                may_wait
                and self._pending_bytes() <= MAX_PENDING_BYTES
                and self._is_incomplete(message.msg)
            ):
                return
            yield from self._next()

    def _pending_bytes(self) -> int:
        return _size(message.msg for message, _ in self._pending)

    def _is_incomplete(self, image: Any) -> bool:
        """Whether poses, odometry or colour for the time of an image may still arrive."""
        if self._settings.synchronous:
            return False
        stamp = seconds(image)
        target = self._settings.map_frame or self._base
        if self._tree.is_pending(target, image.header.frame_id, stamp):
            return True
        expected = self._topics.odometry is not None or self._settings.odom_frame is not None
        if expected and not self._buffer.covers(stamp):
            return True
        if self._topics.colour is None:
            return False
        return not any(seconds(image) >= stamp - MAX_COLOUR_OFFSET_S for image in self._colours)

    def _next(self) -> Iterator[RgbdFrame]:
        """The frame that has waited longest, unless it is broken."""
        message, own_odometry = self._pending.popleft()
        self._count += 1
        try:
            frame = self._frame(message.msg, own_odometry)
            self._compare_clocks(frame, message.log_time)
            yield frame
        except CircumspectError as error:
            self.skipped[f"frame {self._count} at {seconds(message.msg):.3f} s"] = str(error)
            self._warnings.warn(f"frame {self._count} skipped: {error}")

    def _compare_clocks(self, frame: RgbdFrame, log_time: int) -> None:
        was_known = self._clocks.warning
        warning = self._clocks.on_image(
            frame.stamp, log_time / NANOSECONDS, frame.odometry is not None
        )
        if warning:
            self.skipped["odometry"] = warning
        if warning and not was_known:
            _log.warning("%s; frames have no odometry", warning)

    def _frame(self, image: Any, own_odometry: Odometry | None) -> RgbdFrame:
        settings, stamp, camera = self._settings, seconds(image), self._camera
        if camera is None:
            raise InputError(self._no_camera())
        depth = depth_of(image, settings.depth_scale)
        if depth.shape != (camera.height, camera.width):
            raise InputError(
                f"the depth has {depth.shape[1]} x {depth.shape[0]} pixels, the CameraInfo "
                f"{camera.width} x {camera.height}"
            )
        optical = image.header.frame_id
        mount = settings.T_base_camera
        if mount is None:
            mount = self._tree.between(self._base, optical, stamp)
        pose = None
        if settings.map_frame is not None:
            pose = self._tree.between(settings.map_frame, optical, stamp)
        odometry = own_odometry if settings.synchronous else self._buffer.at(stamp)
        colour = self._colour_at(stamp, depth)
        return RgbdFrame(depth, camera, stamp, pose, colour, odometry, mount)

    def _colour_at(self, stamp: float, depth: NDArray[np.float32]) -> NDArray[np.uint8] | None:
        """The colour image nearest in time, if it is registered to the depth image."""
        nearest = min(self._colours, key=lambda image: abs(seconds(image) - stamp), default=None)
        if nearest is None or abs(seconds(nearest) - stamp) > MAX_COLOUR_OFFSET_S:
            return None
        if (nearest.height, nearest.width) != depth.shape:
            return None
        try:
            return colour_of(nearest)
        except InputError as error:
            self._warnings.warn(f"colour skipped: {error}")
            return None


def _size(images: Iterable[Any]) -> int:
    """Total size of the pixels [bytes]."""
    return sum(len(image.data) for image in images)


def _clock_jump(before: _ImageTimes | None, now: _ImageTimes) -> float:
    """Jump of the clock between two images [s]; 0 if there is none."""
    if before is None:
        return 0.0
    step, waited = now[0] - before[0], now[1] - before[1]
    if step < -MAX_BACKWARD_JUMP_S:
        return step
    return step - waited if step > waited + MAX_FORWARD_JUMP_S else 0.0
