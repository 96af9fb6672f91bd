"""The frames of a bag."""

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
from circumspect.recording.topic_choice import TopicNames, chosen, require_info
from circumspect.sensing import RgbdFrame

SHOWN = 12
"""Of the names of frames that a complaint lists."""
UNTOLD = "frames without a place"
"""Under this name they are kept among what is skipped."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class BagSettings:
    """How a bag is to be understood.

    Attributes:
        topics: Those that are known; others are guessed.
        camera: Instead of CameraInfo.
        T_base_camera: Instead of transforms.
        map_frame: In which transforms tell poses.
        depth_scale: Metres a unit of the depth images; None for those of their encoding.
    """

    topics: TopicNames = field(default_factory=TopicNames)
    camera: PinholeCamera | None = None
    T_base_camera: RigidTransform | None = None
    map_frame: str = MAP
    depth_scale: float | None = None


class BagRecording(Recording):
    """Frames of a bag, with odometry and mount where it tells them.

    Memory does not grow with the bag: messages are read one after the other.
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
            every: Take each n-th frame only.
            poses: Whether frames bring along the poses that transforms tell.
            settings: How the bag is to be understood.

        Raises:
            InputError: No topic holds depth images, or several may; nothing tells of the camera;
                `every` is below 1.
        """
        super().__init__(bag.path)
        if every < 1:
            raise InputError(f"every {every}: take each first, second, … frame")
        self.bag, self.every, self.poses = bag, every, poses
        self.settings = settings or BagSettings()
        self.topics = chosen(bag, self.settings.topics)
        if self.settings.camera is None:
            require_info(bag, self.topics)

    @property
    def systematic_disparity(self) -> float | None:
        """Systematic error of the camera's disparity [rad]; None if the bag holds no valid note."""
        try:
            error = float(self.bag.notes.get(SYSTEMATIC_DISPARITY, "nan"))
        except ValueError:
            return None
        return error if 0 <= error < 1 else None

    def __len__(self) -> int:
        """See `Recording.__len__`."""
        return -(-self.bag.topics[self.topics.depth].count // self.every)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """See `Recording.__iter__`; of a bag that breaks off the frames before are given."""
        return self._given(self._assembly())

    def placed(self) -> Iterator[RgbdFrame]:
        """See `Recording.placed`; the mount says it, or a recorded pose."""
        assembly = self._assembly()
        frames = self._given(assembly)
        lack = "where the camera is mounted on the robot", "give --mount X Y Z PAN TILT"
        for first in self._told(frames, _has_place, assembly, *lack):
            yield first
            yield from frames

    def with_poses(self) -> Iterator[RgbdFrame]:
        """The frames with their recorded poses; those without one are left out.

        Raises:
            InputError: Transforms tell none at all; see `__iter__` for what else.
        """
        assembly = self._assembly()
        lack = (
            f"where the camera is in the frame '{self.settings.map_frame}'",
            "name another by --map-frame, or leave --poses out",
        )
        return self._told(self._given(assembly), _has_pose, assembly, *lack)

    def _told(
        self,
        frames: Iterator[RgbdFrame],
        is_told: Callable[[RgbdFrame], bool],
        assembly: FrameAssembly,
        what: str,
        remedy: str,
    ) -> Iterator[RgbdFrame]:
        """The frames for which transforms tell what is needed; there must be one."""
        given = left = 0
        for frame in frames:
            if is_told(frame):
                given += 1
                yield frame
                continue
            left += 1
            self.skipped[UNTOLD] = f"{left}, for no transforms told {what} at their time"
        if not given:
            # Who reads the complaint need not be told of every frame as well.
            self.skipped.pop(UNTOLD)
            names = sorted(assembly.known_frames)
            told = ", ".join(names[:SHOWN]) + (", …" if len(names) > SHOWN else "")
            raise InputError(
                f"{self.path}: no transforms tell {what} when an image was taken; they tell of: "
                f"{told or 'none'}; {remedy}"
            )

    def _given(self, assembly: FrameAssembly) -> Iterator[RgbdFrame]:
        given = 0
        for number, frame in enumerate(self._frames(assembly)):
            if number % self.every:
                continue
            given += 1
            yield frame
        for name, reason in self.bag.left_out.items():
            self.skipped[name] = reason
            _log.warning("%s: %s left out: %s", self.path, name, reason)
        if not given:
            name, reason = next(iter(self.skipped.items()), ("the depth", "there is no image"))
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
                yield from assembly.heard(message)
        except ClockError as error:
            self.skipped["the rest"] = str(error)
            _log.warning("%s: %s", self.path, error)
        yield from assembly.rest()


def _has_pose(frame: RgbdFrame) -> bool:
    return frame.T_map_camera is not None


def _has_place(frame: RgbdFrame) -> bool:
    """Whether registration can begin with it."""
    return frame.T_base_camera is not None or _has_pose(frame)
