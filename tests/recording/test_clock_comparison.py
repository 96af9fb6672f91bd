"""Odometry on another clock than the images."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from foreign_bags import COUNT, TimedMessage, driven, mcap, robots_messages

from circumspect.recording import open_recording
from circumspect.recording.message_clocks import MIN_UNMATCHED, ClockComparison
from circumspect.recording.pose_messages import odometry_message
from circumspect.recording.ros_types import ODOMETRY
from circumspect.sensing import Odometry


def warnings(ahead: float, silence: float = 0.0, matched: bool = False) -> list[str]:
    clocks = ClockComparison()
    found = []
    for number in range(2 * MIN_UNMATCHED):
        now = 0.1 * number
        clocks.on_odometry(now - silence + ahead, now - silence)
        found.append(clocks.on_image(now, now, matched))
    return found


@pytest.mark.parametrize(
    ("ahead", "words"),
    [(1.7e9, "1700000000.0 s ahead of"), (-1.7e9, "1700000000.0 s behind"), (-1.0, "1.0 s behind")],
)
def test_unmatched_images_of_another_clock_are_noticed(ahead: float, words: str) -> None:
    found = warnings(ahead)
    assert found[: MIN_UNMATCHED - 1] == [""] * (MIN_UNMATCHED - 1)
    assert found[MIN_UNMATCHED - 1] == (
        "odometry and images are on different clocks: stamps of odometry are "
        f"{words} those of images that arrive with it"
    )
    assert len(set(found[MIN_UNMATCHED - 1 :])) == 1


@pytest.mark.parametrize(
    ("ahead", "silence", "matched"), [(0.2, 0.0, False), (1.7e9, 2.0, False), (5.0, 0.0, True)]
)
def test_late_missing_and_matching_odometry_is_on_the_clock(
    ahead: float, silence: float, matched: bool
) -> None:
    assert set(warnings(ahead, silence, matched)) == {""}


@pytest.mark.parametrize("ahead", [1.7e9, 100.0])
def test_a_bag_with_two_clocks_is_matched_by_its_log_times(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, ahead: float
) -> None:
    path = mcap(tmp_path, [on_another_clock(one, ahead) for one in robots_messages()])
    recording = open_recording(path)
    found = list(recording)
    assert len(found) == COUNT
    for one in found:
        assert one.odometry is not None
        assert one.odometry.T_odom_base.xy == pytest.approx(driven(one.stamp).xy, abs=1e-4)
    assert not recording.skipped
    assert caplog.text.count("matched by the bag's log times") == 1
    assert f"stamps on /odom are {ahead:.1f} s ahead of those of the depth images" in caplog.text


def test_a_bag_whose_clock_starts_at_zero_has_odometry_from_the_first_image(tmp_path: Path) -> None:
    found = list(open_recording(mcap(tmp_path, robots_messages())))
    assert found[0].stamp == 0.0
    for one in found:
        assert one.odometry is not None
        expected = driven(one.stamp)
        assert one.odometry.T_odom_base.xy == pytest.approx(expected.xy, abs=1e-6)
        assert one.odometry.T_odom_base.yaw == pytest.approx(expected.yaw, abs=1e-6)


def on_another_clock(one: TimedMessage, ahead: float = 1.7e9) -> TimedMessage:
    topic, kind, time, message = one
    if kind == ODOMETRY:
        odometry = Odometry(time + ahead, driven(time), np.zeros((3, 3)))
        message = odometry_message(odometry, "odom", "base_footprint")
    return topic, kind, time, message
