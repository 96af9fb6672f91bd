"""The frames of a bag."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.bag import Bag
from circumspect.recording.frame_assembly import AssemblySettings, ClockError, FrameAssembly
from circumspect.recording.recording import GivenPoses, Recording
from circumspect.recording.run_recorder import MAP, SYNCHRONOUS
from circumspect.recording.topic_choice import TopicNames, chosen, require_info
from circumspect.sensing import RgbdFrame

SHOWN = 12
"""Of the names of frames that a complaint lists."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class BagSettings:
    """How a bag is to be understood.

    Attributes:
        topics: Those that are known; others are guessed.
        camera: Instead of CameraInfo.
        T_base_camera: Instead of transforms.
        map_frame: In which transforms tell poses.
    """

    topics: TopicNames = field(default_factory=TopicNames)
    camera: PinholeCamera | None = None
    T_base_camera: RigidTransform | None = None
    map_frame: str = MAP


class BagRecording(Recording):
    """Frames of a bag, with odometry and mount where it tells them.

    Memory does not grow with the bag: messages are read one after the other.
    """

    def __init__(
        self,
        bag: Bag,
        every: int = 1,
        poses: GivenPoses = GivenPoses.ALL,
        settings: BagSettings | None = None,
    ) -> None:
        """Choose the topics.

        Args:
            bag: The messages.
            every: Take each n-th frame only.
            poses: Which of the poses that transforms tell frames bring along.
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

    def __len__(self) -> int:
        """See `Recording.__len__`."""
        return -(-self.bag.topics[self.topics.depth].count // self.every)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """See `Recording.__iter__`; of a bag that breaks off the frames before are given."""
        return self._given(self._assembly())

    def with_poses(self) -> Iterator[RgbdFrame]:
        """The frames, each with its recorded pose.

        Raises:
            InputError: Transforms do not tell one; see `__iter__` for what else.
        """
        assembly = self._assembly()
        for frame in self._given(assembly):
            if frame.T_map_camera is None:
                names = sorted(assembly.known_frames)
                told = ", ".join(names[:SHOWN]) + (", …" if len(names) > SHOWN else "")
                raise InputError(
                    f"{self.path}: no transforms tell where the camera is in the frame "
                    f"'{self.settings.map_frame}' at {frame.stamp:.3f} s; they told so far of: "
                    f"{told or 'none'}; name another by --map-frame, or leave --poses out"
                )
            yield frame

    def _given(self, assembly: FrameAssembly) -> Iterator[RgbdFrame]:
        given = 0
        for number, frame in enumerate(self._frames(assembly)):
            if number % self.every:
                continue
            hidden = self.poses is GivenPoses.FIRST and given > 0
            given += 1
            yield replace(frame, T_map_camera=None) if hidden else frame
        if self.bag.fault is not None:
            self.skipped["the end"] = self.bag.fault
            _log.warning("%s: %s", self.path, self.bag.fault)
        if not given:
            why = next(iter(self.skipped.values()), "there is no depth image")
            raise InputError(f"{self.path}: no frame can be read: {why}")

    def _assembly(self) -> FrameAssembly:
        s = self.settings
        wanted = None if self.poses is GivenPoses.NONE else s.map_frame
        synchronous = self.bag.notes.get(SYNCHRONOUS) == "true"
        return FrameAssembly(
            self.topics, AssemblySettings(s.camera, s.T_base_camera, wanted, synchronous)
        )

    def _frames(self, assembly: FrameAssembly) -> Iterator[RgbdFrame]:
        self.skipped = assembly.skipped
        try:
            for message in self.bag.messages(self.topics.all):
                yield from assembly.heard(message)
        except ClockError as error:
            self.skipped["the rest"] = str(error)
            _log.warning("%s: %s", self.path, error)
        yield from assembly.rest()
