"""Whether odometry and images are stamped by the same clock, by the times at which they arrive."""

from __future__ import annotations

from circumspect.recording.pose_interpolation import APART, NEAR

MIN_UNMATCHED = 5
"""Images in a row without odometry that make a difference of clocks."""
MAX_SILENCE_S = 1.0
"""Odometry that did not arrive for longer is missing, whatever its stamps."""

Moment = tuple[float, float]
"""Stamp of a message [s] and time at which it arrived [s]."""


class ClockComparison:
    """Finds out why images have no odometry.

    Attributes:
        warning: How far the clocks differ; empty if they do not.
    """

    def __init__(self) -> None:
        """Assume a common clock."""
        self.warning = ""
        self._odometry: Moment | None = None
        self._unmatched = 0

    def on_odometry(self, stamp: float, arrival: float) -> None:
        """Take note of an odometry message; times as in `Moment`."""
        self._odometry = stamp, arrival

    def on_image(self, stamp: float, arrival: float, matched: bool) -> str:
        """Take note of an image.

        Args:
            stamp: Of the image [s].
            arrival: When it arrived [s].
            matched: Whether there is odometry at its stamp.

        Returns:
            The warning, if it is why the image has no odometry.
        """
        ahead = self._odometry_ahead(stamp, arrival)
        if matched or ahead is None or abs(ahead) <= NEAR + APART / 2:
            self._unmatched = 0
            return ""
        self._unmatched += 1
        if self._unmatched < MIN_UNMATCHED:
            return ""
        order = "ahead of" if ahead > 0 else "behind"
        # The first one stays: with figures that vary it would be another one each time.
        self.warning = self.warning or (
            "odometry and images are on different clocks: stamps of odometry are "
            f"{abs(ahead):.1f} s {order} those of images that arrive with it"
        )
        return self.warning

    def _odometry_ahead(self, stamp: float, arrival: float) -> float | None:
        """How far the clock of the odometry is ahead [s]; None while no odometry arrives."""
        if self._odometry is None or abs(self._odometry[1] - arrival) > MAX_SILENCE_S:
            return None
        return (self._odometry[0] - self._odometry[1]) - (stamp - arrival)
