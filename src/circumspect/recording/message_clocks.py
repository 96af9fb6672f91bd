"""Clocks of a bag: correction of stamps to the clock of its depth images."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from statistics import median
from typing import Any

from circumspect.recording.bag import BagMessage
from circumspect.recording.pose_interpolation import MAX_INTERPOLATION_GAP_S, MAX_STAMP_DISTANCE_S
from circumspect.recording.ros_time import NANOSECONDS, nanoseconds_of, set_nanoseconds

MAX_LATENCY_S = 2.0
"""Smaller clock differences cannot be distinguished from message latency [s]."""
SAMPLES, MAX_SAMPLES = 20, 5000
"""Messages that determine the clock of a source, and maximum kept while waiting for others."""
MAX_GAP_S = 1.0
"""Maximum difference of the log times of compared messages [s]."""
Source = tuple[str, str]
"""Topic, and the child frame of a transform; "" for other messages."""
LoggedStamp = tuple[int, int]
"""Stamp and log time [ns]."""
_log = logging.getLogger(__name__)
MIN_UNMATCHED = 5
"""Consecutive images without odometry that indicate different clocks."""
MAX_SILENCE_S = 1.0
"""Time without odometry messages after which odometry counts as missing [s]."""
Moment = tuple[float, float]
"""Stamp of a message [s] and time at which it arrived [s]."""


class ClockComparison:
    """Determines whether images lack odometry because of different clocks.

    Attributes:
        warning: Description of the clock difference; empty if there is none.
    """

    def __init__(self) -> None:
        """Assume a common clock."""
        self.warning = ""
        self._odometry: Moment | None = None
        self._unmatched = 0

    def on_odometry(self, stamp: float, arrival: float) -> None:
        """Record an odometry message; times as in `Moment`."""
        self._odometry = stamp, arrival

    def on_image(self, stamp: float, arrival: float, matched: bool) -> str:
        """Record an image.

        Args:
            stamp: Stamp of the image [s].
            arrival: Time at which it arrived [s].
            matched: Whether odometry exists for its stamp.

        Returns:
            The warning if different clocks explain the missing odometry, else an empty string.
        """
        ahead = self._odometry_ahead(stamp, arrival)
        if (
            matched
            or ahead is None
            or abs(ahead) <= MAX_STAMP_DISTANCE_S + MAX_INTERPOLATION_GAP_S / 2
        ):
            self._unmatched = 0
            return ""
        self._unmatched += 1
        if self._unmatched < MIN_UNMATCHED:
            return ""
        order = "ahead of" if ahead > 0 else "behind"
        # Keep the first text: its figures vary from image to image.
        self.warning = self.warning or (
            "odometry and images are on different clocks: stamps of odometry are "
            f"{abs(ahead):.1f} s {order} those of images that arrive with it"
        )
        return self.warning

    def _odometry_ahead(self, stamp: float, arrival: float) -> float | None:
        """Lead of the odometry clock [s]; None while no odometry arrives."""
        if self._odometry is None or abs(self._odometry[1] - arrival) > MAX_SILENCE_S:
            return None
        return (self._odometry[0] - self._odometry[1]) - (stamp - arrival)


@dataclass
class ClockSamples:
    """Stamps of the first messages of each source with the bag's log times.

    Attributes:
        moments: Source to pairs of stamp and log time [ns].
    """

    moments: dict[Source, list[LoggedStamp]] = field(default_factory=dict)

    def add(self, message: BagMessage) -> None:
        """Record a message, unless enough messages of its sources are known."""
        for source, header in stamped_headers(message):
            moments = self.moments.setdefault(source, [])
            if len(moments) < MAX_SAMPLES:
                moments.append((nanoseconds_of(header), message.log_time))

    def is_complete(self, topic: str) -> bool:
        """Whether enough messages of one source of a topic are known."""
        return any(len(m) >= SAMPLES for (name, _), m in self.moments.items() if name == topic)


@dataclass(frozen=True)
class MessageClocks:
    """Corrections of stamps.

    Attributes:
        shifts: Source to the correction of its stamps [ns].
        unstamped: Sources with zero stamps to the correction of their log times [ns].
    """

    shifts: Mapping[Source, int] = field(default_factory=dict)
    unstamped: Mapping[Source, int] = field(default_factory=dict)

    @classmethod
    def from_samples(cls, samples: ClockSamples, depth: str, place: str) -> MessageClocks:
        """Compare the clock of each source with that of the depth images; log differences.

        Args:
            samples: The first messages.
            depth: Topic of the depth images.
            place: Name of the bag for the log.
        """
        moments = samples.moments
        unstamped = [source for source, found in moments.items() if not any(s for s, _ in found)]
        images = [] if (depth, "") in unstamped else moments.get((depth, ""), [])
        ahead = {
            source: _ahead(found, images)
            for source, found in moments.items()
            if source not in unstamped
        }
        shifts = {source: -by for source, by in ahead.items() if by}
        for topic in sorted({topic for topic, _ in unstamped}):
            _log.warning("%s: stamps on %s are zero; the bag's log times are used", place, topic)
        for (topic, frame), shift in sorted(shifts.items()):
            order, name = "behind" if shift > 0 else "ahead of", f"{topic} {frame}".rstrip()
            _log.warning(
                "%s: stamps on %s are %.1f s %s those of the depth images; matched by the bag's "
                "log times",
                place, name, abs(shift) / NANOSECONDS, order,
            )  # fmt: skip
        offset = round(median(stamp - log for stamp, log in images)) if images else 0
        return cls(shifts, dict.fromkeys(unstamped, offset))

    def correct(self, message: BagMessage) -> None:
        """Set the stamps of a message to the clock of the depth images, in place."""
        if not self.shifts and not self.unstamped:
            return
        for source, header in stamped_headers(message):
            if (missing := self.unstamped.get(source)) is not None:
                if nanoseconds_of(header) == 0:
                    set_nanoseconds(header, message.log_time + missing)
            elif shift := self.shifts.get(source):
                set_nanoseconds(header, nanoseconds_of(header) + shift)


def stamped_headers(message: BagMessage) -> Iterator[tuple[Source, Any]]:
    """The headers of a message, each with its source."""
    if hasattr(message.msg, "transforms"):
        for stamped in message.msg.transforms:
            yield (message.topic, str(stamped.child_frame_id)), stamped.header
    elif hasattr(message.msg, "header"):
        yield (message.topic, ""), message.msg.header


def _ahead(moments: list[LoggedStamp], images: list[LoggedStamp]) -> int:
    """Lead of a source's clock over that of the images [ns]; 0 if they agree.

    Without stamped images, log times are used.
    """
    limit = MAX_LATENCY_S * NANOSECONDS
    found: list[int] = []
    for stamp, log in moments[:SAMPLES]:
        if not images:
            found.append(stamp - log)
            continue
        image_stamp, image_log = min(images, key=lambda moment: abs(moment[1] - log))
        if abs(image_log - log) <= MAX_GAP_S * NANOSECONDS:
            found.append((stamp - log) - (image_stamp - image_log))
    if not found or max(found) - min(found) > limit:
        return 0
    middle = round(median(found))
    return middle if abs(middle) > limit else 0
