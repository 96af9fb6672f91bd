"""A place far from where the camera should be needs good evidence."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform
from tracking_world import THINGS, drive, true_camera

from circumspect.mapping import TrackingSettings
from circumspect.mapping.motion import Belief
from circumspect.mapping.recognition import Recognition
from circumspect.mapping.relocalisation import (
    SAME_PLACE,
    RelocalisationSettings,
    relocalise,
    within,
)
from circumspect.registration import Registration, Scan, ScanSurface, SurfaceMap, violation_ratio
from circumspect.sensing import RgbdFrame
from circumspect.simulation import Surface, block

USUAL = 4000.0
HERE = Belief(RigidTransform.identity(), np.eye(6) * 1e-4)
STEP = RigidTransform.from_translation([0.05, 0.0, 0.0])
STILL = RigidTransform.identity()


def fit(x: float, inliers: int = 4000) -> Registration:
    place = RigidTransform.from_translation([x, 0.0, 0.0])
    known = np.eye(6) * 1e4
    return Registration(
        place, known, known, np.zeros(6), inliers, inliers, 1.0, 0.001, 0.001, 1.0, 5, True
    )


def believed(
    recognition: Recognition, fits: list[Registration], *expected, ambiguous=(), **how
) -> Registration | None:
    """As if the frame fitted aside of the places with these numbers, too."""
    aside = [fits[number] for number in ambiguous]
    return recognition.believed(fits, *expected, **how, ambiguous=aside.__contains__)


@pytest.fixture
def recognition() -> Recognition:
    return Recognition(RelocalisationSettings(), farthest=38.0)


def test_a_place_near_by_counts_at_once(recognition: Recognition) -> None:
    near = fit(0.2)
    assert believed(recognition, [near], HERE, STILL, USUAL, lost=False, out_of_place=False) is near
    far_too = [fit(3.0), near]
    assert (
        believed(recognition, far_too, HERE, STILL, USUAL, lost=False, out_of_place=False) is near
    )


@pytest.mark.parametrize(("metres", "at_once"), [(0.3, True), (0.6, False)])
def test_where_the_camera_may_be_anywhere_a_near_place_needs_several_frames(
    recognition: Recognition, metres: float, at_once: bool
) -> None:
    """To a camera that may be anywhere every place is near."""
    vague = Belief(STILL, np.diag([0.01] * 3 + [metres] * 3) ** 2)
    told = [
        believed(recognition, [fit(0.2)], vague, STILL, USUAL, lost=True, out_of_place=True)
        for _ in range(3)
    ]
    assert [found is not None for found in told] == [at_once, at_once, True]


@pytest.mark.parametrize(("lost", "contrary"), [(False, False), (True, False), (True, True)])
def test_a_place_where_the_camera_is_hardly_counts_when_several_frames_tell_of_it(
    recognition: Recognition, lost: bool, contrary: bool
) -> None:
    told = [
        believed(
            recognition, [fit(0.9 + 0.05 * n)], HERE, STEP, USUAL, lost=lost, out_of_place=contrary
        )
        for n in range(4)
    ]
    assert [found is not None for found in told] == [False, False, True, True]


def test_a_lost_camera_before_news_is_found_near_by_when_several_frames_tell_of_it(
    recognition: Recognition,
) -> None:
    def found(*places: float) -> bool:
        fits = [fit(x) for x in places]
        return (
            believed(recognition, fits, HERE, STILL, USUAL, lost=True, out_of_place=False)
            is not None
        )

    assert [found(0.1) for _ in range(3)] == [False, False, True]
    assert [found(0.1, 3.0) for _ in range(4)] == 4 * [False]


def test_what_is_supposed_goes_along_over_frames_that_say_nothing(
    recognition: Recognition,
) -> None:
    step, found = RigidTransform.from_translation([0.2, 0.0, 0.0]), []
    for number in range(3):
        fits = [fit(3.0 + 0.6 * number)]
        told = believed(recognition, fits, HERE, step, USUAL, lost=True, out_of_place=True)
        found.append(told is not None)
        recognition.carry(step)
        recognition.carry(step)
    assert found == [False, False, True]


def test_a_few_points_tell_of_no_place(recognition: Recognition) -> None:
    assert (
        believed(
            recognition, [fit(0.2, inliers=1500)], HERE, STILL, USUAL, lost=True, out_of_place=True
        )
        is None
    )


def test_of_two_places_near_by_none_counts(recognition: Recognition) -> None:
    fits = [fit(0.2), fit(-0.2)]
    assert believed(recognition, fits, HERE, STILL, USUAL, lost=True, out_of_place=True) is None


def far(recognition: Recognition, times: int, **changed) -> list[bool]:
    """Whether a place 3 m off that moves along is believed, frame by frame."""
    usual = {"inliers": 4000, "step": STEP, "lost": True, "others": [], "contrary": True}
    how = {**usual, **changed}
    return [
        believed(
            recognition,
            [fit(3.0 + 0.05 * n, how["inliers"]), *how["others"]],
            HERE, how["step"], USUAL, lost=how["lost"], out_of_place=how["contrary"],
        ) is not None
        for n in range(times)
    ]  # fmt: skip


def test_a_far_place_counts_when_several_frames_tell_of_it(recognition: Recognition) -> None:
    assert far(recognition, 4) == [False, False, True, True]


def test_frames_that_tell_of_different_places_count_for_nothing(recognition: Recognition) -> None:
    metre_back = RigidTransform.from_translation([-1.0, 0.0, 0.0])
    assert not any(far(recognition, 6, step=metre_back))


@pytest.mark.parametrize(
    "changed",
    [{"lost": False}, {"inliers": 1500}, {"others": [fit(-4.0)]}, {"contrary": False}],
)
def test_a_far_place_does_not_count(recognition: Recognition, changed: dict) -> None:
    """Not before the camera is lost, not by a few points, not where there is another, and not
    where nothing speaks against the place where the camera should be.
    """
    assert not any(far(recognition, 6, **changed))


def test_one_frame_that_is_placed_begins_the_count_anew(recognition: Recognition) -> None:
    far(recognition, 2)
    recognition.forget()
    assert far(recognition, 3) == [False, False, True]


def test_frames_that_fit_aside_as_well_tell_of_no_place(recognition: Recognition) -> None:
    """Two that did, and a third that just did not, had a corner 4 m off believed."""
    told = [
        believed(
            recognition, [fit(3.0)], HERE, STILL, USUAL, lost=True, out_of_place=True,
            ambiguous=aside,
        ) is not None
        for aside in ([0], [0], [], [0], [], [], [])
    ]  # fmt: skip
    assert told == 6 * [False] + [True]
    near = {"lost": False, "out_of_place": False}
    assert believed(recognition, [fit(0.2)], HERE, STILL, USUAL, **near, ambiguous=[0]) is None
    # It may be there, though.
    fits = [fit(0.2), fit(-0.2)]
    assert believed(recognition, fits, HERE, STILL, USUAL, **near, ambiguous=[1]) is None


def mapped(frames: list[RgbdFrame], places: list[RigidTransform]) -> SurfaceMap:
    """What frames from known places show."""
    scan = TrackingSettings().scan
    surfaces = [
        (
            ScanSurface.from_scan(Scan.from_frame(frame, scan)).with_vertical_floor_normals(place),
            place,
        )
        for frame, place in zip(frames, places, strict=True)
    ]
    return SurfaceMap(scan.voxel).with_surfaces(surfaces)


@pytest.mark.parametrize(
    ("degrees", "rest_is_news", "least_known", "found"),
    [
        pytest.param(20.0, False, 0.5, True, id="all known"),
        pytest.param(45.0, False, 0.5, False, id="a quarter elsewhere"),
        pytest.param(45.0, True, 0.5, True, id="a quarter new"),
        pytest.param(45.0, True, 0.8, False, id="too much of it new"),
        pytest.param(80.0, True, 0.5, False, id="looks through what is known"),
    ],
)
def test_what_nobody_looked_at_so_far_does_not_speak_against_a_place(
    degrees: float, rest_is_news: bool, least_known: float, found: bool
) -> None:
    angles = np.radians(np.arange(-30, 25, 5.0))
    places = [true_camera(float(angle)) for angle in angles]
    scene, s = mapped(drive(angles), places), TrackingSettings()
    angle = float(np.radians(degrees))
    (frame,) = drive(np.array([angle]))
    settings = replace(s.relocalisation, least_known=least_known)
    fits = relocalise(
        partial(violation_ratio, frame, scene), Scan.from_frame(frame, s.scan), scene, places[0],
        places, s.registration, s.gate, settings,
        lambda fit, contrary: rest_is_news,
    )  # fmt: skip
    assert len(fits) == int(found)
    for fit in fits:
        off = fit.T_map_camera.translation - true_camera(angle).translation
        assert np.linalg.norm(off) < 0.01


def test_a_camera_is_found_from_about_where_it_should_be() -> None:
    """As after a wheel that slipped, where the places that it was at are too far off."""
    angles, angle = np.radians(np.arange(-30, 25, 5.0)), float(np.radians(30.0))
    places = [true_camera(float(a)) for a in angles]
    scene, s, true = mapped(drive(angles), places), TrackingSettings(), true_camera(angle)
    (frame,) = drive(np.array([angle]))
    slipped = RigidTransform.from_exp_coords([0.0, float(np.radians(7.0)), 0.0, 0.04, 0.0, 0.02])
    for expected, count in ((places[0], 0), (true * slipped, 1)):
        fits = relocalise(
            partial(violation_ratio, frame, scene), Scan.from_frame(frame, s.scan), scene, expected,
            places[:1], s.registration, s.gate, s.relocalisation, lambda fit, contrary: True,
        )  # fmt: skip
        assert len(fits) == count
    assert np.linalg.norm(fits[0].T_map_camera.translation - true.translation) < 0.01


def test_a_square_pillar_looks_alike_from_its_four_sides() -> None:
    """And who is lost beside one is not told to be at one of them."""
    square = (Surface("object", block((-0.25, -0.25, 0.0), (0.25, 0.25, 0.8))), THINGS[2])
    angles = np.radians(np.arange(5, 365, 10.0))
    frames = drive(angles, things=square)
    places = [true_camera(float(angle)) for angle in angles]
    s = TrackingSettings()
    frame, scene = frames[4], mapped(frames, places)
    fits = relocalise(
        partial(violation_ratio, frame, scene), Scan.from_frame(frame, s.scan), scene, places[4],
        places, s.registration, s.gate, s.relocalisation, lambda fit, contrary: False,
    )  # fmt: skip
    assert len(fits) >= 2
    assert not any(
        within(a.T_map_camera, b.T_map_camera, SAME_PLACE) for a, b in combinations(fits, 2)
    )
    nowhere = Belief(RigidTransform.from_translation([0.0, 0.0, 50.0]), np.eye(6) * 1e-4)
    recognition = Recognition(s.relocalisation, s.gate.farthest)
    for _ in range(5):
        assert (
            believed(recognition, fits, nowhere, STILL, 0.0, lost=True, out_of_place=True) is None
        )
