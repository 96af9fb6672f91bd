"""A bag read as a recording of RGB-D frames."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.bag import Bag
from circumspect.recording.bag_preview import BagPreview, preview
from circumspect.recording.frame_assembly import AssemblySettings, ClockError, FrameAssembly
from circumspect.recording.recording import Recording
from circumspect.recording.run_recorder import MAP, SYNCHRONOUS, SYSTEMATIC_DISPARITY
from circumspect.recording.topic_choice import TopicNames, choose_topics, require_info
from circumspect.sensing import RgbdFrame

MAX_LISTED_FRAMES = 12
"""Number of frame names that an error message lists."""
UNLOCATED = "frames without a pose"
"""Key of these frames in `skipped`."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class BagSettings:
    """How to interpret a bag.

    Attributes:
        topics: Known topic names; the others are guessed.
        camera: Intrinsics to use instead of CameraInfo.
        T_base_camera: Mount to use instead of transforms.
        map_frame: Frame of the recorded poses.
        depth_scale: Metres per unit of the depth images; None for the default of their encoding.
    """

    topics: TopicNames = field(default_factory=TopicNames)
    camera: PinholeCamera | None = None
    T_base_camera: RigidTransform | None = None
    map_frame: str = MAP
    depth_scale: float | None = None


class BagRecording(Recording):
    """Frames of a bag, with wheel odometry and camera mount if the bag contains them.

    Messages are read one after the other, so memory does not grow with the bag.
    """

    def __init__(
        self,
        bag: Bag,
        every: int = 1,
        poses: bool = True,
        settings: BagSettings | None = None,
    ) -> None:
        """Choose the topics.

        Args:
            bag: The messages.
            every: Use every n-th frame only.
            poses: Whether frames carry the poses given by transforms.
            settings: How to interpret the bag.

        Raises:
            InputError: No topic, or more than one, may hold the depth images; the camera is
                unknown; `every` is below 1.
        """
        super().__init__(bag.path, every, poses)
        self.bag = bag
        self.settings = settings or BagSettings()
        self.topics = choose_topics(bag, self.settings.topics)
        if self.settings.camera is None:
            require_info(bag, self.topics)

    @property
    def has_floor(self) -> bool:
        """See `Recording.has_floor`; the map of a bag starts on the floor under the robot."""
        return True

    @property
    def systematic_disparity(self) -> float | None:
        """Systematic error of the camera's disparity [rad]; None if the bag has no valid note."""
        try:
            error = float(self.bag.notes.get(SYSTEMATIC_DISPARITY, "nan"))
        except ValueError:
            return None
        return error if 0 <= error < 1 else None

    def __len__(self) -> int:
        """See `Recording.__len__`."""
        return -(-self.bag.topics[self.topics.depth].count // self.every)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """See `Recording.__iter__`; a truncated bag yields the frames before the break."""
        return self._readable_frames(self._assembly())

    def from_first_pose(self) -> Iterator[RgbdFrame]:
        """See `Recording.from_first_pose`; the pose is the mount or a recorded pose."""
        assembly = self._assembly()
        frames = self._readable_frames(assembly)
        missing = "mount of the camera on the robot", "give --mount X Y Z PAN TILT"
        for first in self._located(frames, _has_place, assembly, *missing):
            yield first
            yield from frames

    def with_poses(self) -> Iterator[RgbdFrame]:
        """Iterate over the frames with recorded poses; frames without a pose are skipped.

        Raises:
            InputError: No frame has a pose; see `__iter__` for other errors.
        """
        assembly = self._assembly()
        missing = (
            f"pose of the camera in the frame '{self.settings.map_frame}'",
            "choose another frame with --map-frame, or omit --poses",
        )
        return self._located(self._readable_frames(assembly), _has_pose, assembly, *missing)

    def _located(
        self,
        frames: Iterator[RgbdFrame],
        is_located: Callable[[RgbdFrame], bool],
        assembly: FrameAssembly,
        what: str,
        remedy: str,
    ) -> Iterator[RgbdFrame]:
        """The frames whose pose is given by transforms; there must be at least one."""
        count = left = 0
        for frame in frames:
            if is_located(frame):
                count += 1
                yield frame
                continue
            left += 1
            self.skipped[UNLOCATED] = f"{left}: no transform gives the {what} at their times"
        if not count:
            # One error replaces the note on each frame.
            self.skipped.pop(UNLOCATED)
            names = sorted(assembly.known_frames)
            known = ", ".join(names[:MAX_LISTED_FRAMES]) + ", …" * (len(names) > MAX_LISTED_FRAMES)
            raise InputError(
                f"{self.path}: no transform gives the {what} at the time of any image; known "
                f"frames: {known or 'none'}; {remedy}"
            )

    def _readable_frames(self, assembly: FrameAssembly) -> Iterator[RgbdFrame]:
        count = 0
        for number, frame in enumerate(self._frames(assembly)):
            if number % self.every:
                continue
            count += 1
            yield frame
        for name, reason in self.bag.left_out.items():
            self.skipped[name] = reason
            _log.warning("%s: %s left out: %s", self.path, name, reason)
        if not count:
            name, reason = next(iter(self.skipped.items()), ("depth", "there is no image"))
            raise InputError(f"{self.path}: no frame can be read: {name}: {reason}")

    def _assembly(self) -> FrameAssembly:
        s = self.settings
        wanted = s.map_frame if self.poses else None
        synchronous = self.bag.notes.get(SYNCHRONOUS) == "true"
        settings = AssemblySettings(
            s.camera, s.T_base_camera, wanted, synchronous, depth_scale=s.depth_scale
        )
        return FrameAssembly(self.topics, settings)

    def _frames(self, assembly: FrameAssembly) -> Iterator[RgbdFrame]:
        self.skipped = assembly.skipped
        begin = BagPreview()
        if self.bag.notes.get(SYNCHRONOUS) != "true":
            begin = preview(self.bag, self.topics, self.settings.camera is None)
        assembly.begin_with(begin.info, begin.static)
        try:
            for message in self.bag.messages(self.topics.all):
                begin.clocks.correct(message)
                yield from assembly.on_message(message)
        except ClockError as error:
            self.skipped["the rest"] = str(error)
            _log.warning("%s: %s", self.path, error)
        yield from assembly.remaining_frames()


def _has_pose(frame: RgbdFrame) -> bool:
    return frame.T_map_camera is not None


def _has_place(frame: RgbdFrame) -> bool:
    """Whether registration can start with this frame."""
    return frame.T_base_camera is not None or _has_pose(frame)
