"""The track of the intelligent space: its fixes, exclusions and log."""

from __future__ import annotations

import json

from ceiling_world import sighted

from circumspect.localization import LOST, Sighting, SpaceFix, SpaceTrack, SpaceTracker


def without_pose(stamp: float, of: float, reason: str) -> SpaceFix:
    """The fix of images whose stamps are rejected."""
    return SpaceFix(stamp, LOST, None, None, (Sighting("a", of, reason=reason),))


def test_the_log_holds_all_fixes_in_order_of_arrival_with_their_rejections(tmp_path):
    tracker = SpaceTracker()
    first, second = (tracker.take(t, [sighted("a", t, 0.0, 0.0)]) for t in (1.0, 1.1))
    late = without_pose(1.0, 0.9, "late: there is a fix for its time already")
    jump = without_pose(1.0, 5000.0, "its stamp jumps ahead")
    track = SpaceTrack.of([first, late, jump, second])
    assert (track.fixes, track.late, track.clock_jumps) == ((first, second), (late,), (jump,))
    track.write_log(tmp_path / "space.jsonl")
    lines = [json.loads(line) for line in (tmp_path / "space.jsonl").read_text().splitlines()]
    assert [line.pop("excluded", None) for line in lines] == [None, "late", "clock jump", None]
    assert lines == [fix.summary() for fix in (first, late, jump, second)]
    assert lines[1]["rejected"] == {"a": "late: there is a fix for its time already"}
