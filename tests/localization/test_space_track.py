"""What is kept of all that the intelligent space said."""

from __future__ import annotations

import json

from ceiling_world import told

from circumspect.localization import LOST, Sighting, SpaceFix, SpaceTrack, SpaceTracker


def without_news(stamp: float, of: float, reason: str) -> SpaceFix:
    """What is said at a time of images whose stamps can not be believed."""
    return SpaceFix(stamp, LOST, None, None, (Sighting("a", of, reason=reason),))


def test_the_log_holds_all_fixes_in_the_order_of_arrival_with_what_is_wrong(tmp_path):
    tracker = SpaceTracker()
    first, second = (tracker.take(t, [told("a", t, 0.0, 0.0)]) for t in (1.0, 1.1))
    late = without_news(1.0, 0.9, "late: its time was answered already")
    leap = without_news(1.0, 5000.0, "its stamp leaps ahead")
    track = SpaceTrack.of([first, late, leap, second])
    assert (track.fixes, track.late, track.leaps) == ((first, second), (late,), (leap,))
    track.write_log(tmp_path / "space.jsonl")
    lines = [json.loads(line) for line in (tmp_path / "space.jsonl").read_text().splitlines()]
    assert [line.pop("apart", None) for line in lines] == [None, "late", "leap", None]
    assert lines == [fix.summary() for fix in (first, late, leap, second)]
    assert lines[1]["rejected"] == {"a": "late: its time was answered already"}
