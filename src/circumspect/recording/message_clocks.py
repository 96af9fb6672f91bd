"""Stamps of a bag's messages, put onto the clock of its depth images."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from statistics import median
from typing import Any

from circumspect.recording.bag import BagMessage
from circumspect.recording.ros_time import NANOSECONDS, nanoseconds_of, set_nanoseconds

MAX_LATENCY_S = 2.0
"""A smaller difference of clocks can not be distinguished from late messages [s]."""
SAMPLES, MAX_SAMPLES = 20, 5000
"""So many messages of a source show its clock; of one that waits for others so many are kept."""
MAX_GAP_S = 1.0
"""Messages that are compared are no further apart in the bag [s]."""

Source = tuple[str, str]
"""Topic, and the child frame of a transform; "" for other messages."""

Moment = tuple[int, int]
"""Stamp and log time [ns]."""

_log = logging.getLogger(__name__)


@dataclass
class ClockSamples:
    """Stamps of the first messages of each source, beside the bag's log times.

    Attributes:
        moments: Source to pairs of stamp and log time [ns].
    """

    moments: dict[Source, list[Moment]] = field(default_factory=dict)

    def add(self, message: BagMessage) -> None:
        """Take note of a message, unless enough of its sources are known."""
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
        shifts: Source to what its stamps lack [ns].
        unstamped: Sources whose stamps are zero to what their log times lack [ns].
    """

    shifts: Mapping[Source, int] = field(default_factory=dict)
    unstamped: Mapping[Source, int] = field(default_factory=dict)

    @classmethod
    def from_samples(cls, samples: ClockSamples, depth: str, place: str) -> MessageClocks:
        """Compare the clock of each source with that of the depth images; log what differs.

        Args:
            samples: The first messages.
            depth: Topic of the depth images.
            place: The bag's name, for the log.
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
    """The headers of a message, each with its source; CameraInfo and such have one."""
    if hasattr(message.told, "transforms"):
        for stamped in message.told.transforms:
            yield (message.topic, str(stamped.child_frame_id)), stamped.header
    elif hasattr(message.told, "header"):
        yield (message.topic, ""), message.told.header


def _ahead(moments: list[Moment], images: list[Moment]) -> int:
    """How far the clock of a source is ahead of that of the images [ns]; 0 where it is not.

    Without stamped images the log time is their clock.
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
