"""Clocks of ceiling cameras that jump, stand still or are set back, and photos far apart."""

from __future__ import annotations

from dataclasses import replace

import pytest
from ceiling_room import MOUNT, truth

from circumspect.localization import BRIDGED, TRACKED, IntelligentSpace, SpaceTrack


def test_a_single_clock_jump_does_not_make_the_rest_late(rig, pair):
    space = IntelligentSpace(pair[:2], MOUNT)

    def at(stamp):
        return space.locate([replace(i, stamp=stamp) for i in rig.images(truth(stamp=stamp))[:2]])

    assert at(1.0).state == TRACKED
    jump = space.locate([replace(rig.images(truth())[0], stamp=5000.0)])
    assert jump.sightings[0].full_reason == "its stamp jumps ahead (by 4999.0 s)"
    assert at(1.1).state == TRACKED
    # A pause of all cameras is accepted at once, that of one the third time in a row.
    assert [at(100.0 + n / 10).state for n in range(3)] == [TRACKED] * 3
    alone = [space.locate(rig.images(truth(stamp=200.0 + n / 10))[:1]) for n in range(4)]
    assert [fix.state for fix in alone] == [BRIDGED, BRIDGED, TRACKED, TRACKED]


def tracked(rig, space, stamps, clock=None):
    """The track of one camera's images at these stamps [s]; `clock` changes the stamp of one."""
    images = [rig.images(truth(0.02 * n, stamp=stamp))[0] for n, stamp in enumerate(stamps)]
    if clock is not None:
        images[clock[0]] = replace(images[clock[0]], stamp=clock[1])
    return SpaceTrack.of(space.track(images), space.reports)


@pytest.mark.parametrize("count", [3, 5])
def test_photos_far_apart_are_all_part_of_the_path(rig, pair, count):
    stamps = [15.0 * n for n in range(count)]
    track = tracked(rig, IntelligentSpace(pair[:1], MOUNT), stamps)
    assert [fix.stamp for fix in track.known(bridged=False)] == stamps
    assert [fix.T_map_base.x for fix in track.fixes] == pytest.approx(
        [0.02 * n for n in range(count)], abs=0.01
    )
    assert (track.late, track.clock_jumps, track.reports) == ((), (), ())


@pytest.mark.parametrize("step", [0.1, 15.0])
@pytest.mark.parametrize("which", [1, 4, 6])
def test_a_single_clock_jump_is_left_out_of_a_track_and_reported(rig, pair, step, which):
    stamps = [step * n for n in range(7)]
    track = tracked(rig, IntelligentSpace(pair[:1], MOUNT), stamps, (which, 5000.0))
    del stamps[which]
    assert [fix.stamp for fix in track.known(bridged=False)] == stamps
    (jump,) = track.clock_jumps
    assert jump.sightings[0].reason == "its stamp jumps ahead"
    assert track.reports == ("1 fixes jumped ahead of the others and are not part of the path",)
    assert (track.late, track.summary()["late"], track.summary()["clock_jumps"]) == ((), 0, 1)


def test_the_wait_for_a_clock_that_stands_still_ahead_is_bounded(rig, pair):
    space = IntelligentSpace(pair[:1], MOUNT)
    first, second = rig.images(truth())[0], rig.images(truth(0.1))[0]
    taken = []

    def images():
        for n in range(200):
            taken.append(n)
            yield replace(second, stamp=5000.0) if n else first

    fixes = space.track(images())
    assert [next(fixes).state for _ in range(2)] == [TRACKED, BRIDGED]
    assert len(taken) < 40


def test_tracking_goes_on_after_a_clock_is_set_back(rig, pair):
    space = IntelligentSpace(pair[:2], MOUNT)

    def at(stamp, x):
        images = rig.images(truth(x, stamp=stamp))[:2]
        return space.locate([replace(image, stamp=stamp) for image in images])

    assert at(100.0, 0.0).state == TRACKED
    assert at(99.9, 0.0).state == BRIDGED
    assert not space.reports
    fixes = [at(40.0 + n / 10, 0.4) for n in range(4)]
    assert [fix.state for fix in fixes] == [BRIDGED, BRIDGED, TRACKED, TRACKED]
    assert fixes[-1].T_map_base.x == pytest.approx(0.4, abs=0.01)
    assert fixes[-1].stamp == 40.3
    assert space.reports == ("the cameras' clock was set back by 59.8 s at 40.200 s",)


@pytest.mark.parametrize(("before", "after"), [(3, 9), (9, 5)])
def test_of_repeated_times_the_clock_with_more_of_them_is_kept(rig, pair, before, after):
    """A clock set back by five minutes repeats the same times for five minutes."""
    stamps = [300.0 + n / 10 for n in range(before)] + [n / 10 for n in range(after)]
    track = tracked(rig, IntelligentSpace(pair[:1], MOUNT), stamps)
    # The first two after it was set back might have come late.
    old, new = stamps[:before], stamps[before + 2 :]
    path, apart = (new, old) if len(new) > len(old) else (old, new)
    assert [fix.stamp for fix in track.known(bridged=False)] == path
    assert [fix.stamp for fix in track.set_back] == apart
    assert (len(track.late), track.clock_jumps) == (2, ())
    assert track.summary()["set_back"] == len(apart)
    overlap = f"{len(apart)} fixes overlap others because a clock was set back"
    assert track.reports[-1] == f"{overlap} and are not part of the path"


def test_a_temporarily_wrong_clock_loses_only_its_own_fixes(rig, pair):
    """All cameras jump ahead together, which is accepted, and come back."""
    right = [n / 10 for n in range(12)]
    stamps = [*right[:4], *(400.0 + n / 10 for n in range(3)), *right[4:]]
    space = IntelligentSpace(pair, MOUNT)
    images = [
        image
        for n, stamp in enumerate(stamps)
        for image in rig.images(truth(0.02 * n, stamp=stamp))[: len(pair)]
    ]
    track = SpaceTrack.of(space.track(images), space.reports)
    assert [fix.stamp for fix in track.fixes] == [*right[:4], *right[6:]]
    assert [fix.stamp for fix in track.set_back] == stamps[4:7]
