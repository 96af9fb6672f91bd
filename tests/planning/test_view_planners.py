"""Laws of the planners on shapes whose normals are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from analytic_shapes import (
    MOUNT,
    box,
    circle,
    facing_centre,
    l_shape,
    planner_input,
    tour,
    turned_back,
    walls,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.geometry import PlanarPose
from circumspect.planning import (
    Answer,
    CirclePlanner,
    ConfidencePlanner,
    Finished,
    NextView,
    SurfaceNormalPlanner,
    base_pose,
    camera_place,
)
from circumspect.planning.circle_planner import (
    ALL_TRIED,
    MAX_STEP_DEG,
    MIN_STEP_DEG,
    NOTHING_KNOWN,
)
from circumspect.planning.view_planner import AS_FAR_AS_POSSIBLE, ROUND_COMPLETE
from circumspect.robot.path_follower import PathFollower

SHAPES = {
    "circle": circle(0.3),
    "box": box(0.9, 0.45),
    "square": box(0.4, 0.4),
    "L": l_shape(),
    "monitor": box(0.6, 0.03),
}
PLANNERS = {"normals": SurfaceNormalPlanner(), "circle": CirclePlanner()}
FACING_DEG = 8.0


def views(answers) -> list[NextView]:
    return [answer for _, answer in answers if isinstance(answer, NextView)]


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("planner", PLANNERS)
@settings(max_examples=4)
@given(azimuth=st.floats(0, 6.28), askew=st.floats(-0.15, 0.15))
def test_every_shape_is_orbited_from_any_start(shape, planner, azimuth, askew) -> None:
    start = turned_back(facing_centre(azimuth, 1.5), askew)
    answers = list(tour(SHAPES[shape], PLANNERS[planner], start))
    assert answers[-1][1] == Finished(ROUND_COMPLETE)
    for asked, answer in answers[:-1]:
        eye = camera_place(answer.T_map_base, MOUNT).xy
        assert np.linalg.norm(asked.points_xyz[:, :2] - eye, axis=1).min() > 0.75, answer.reason
        # What is not known yet may be a little nearer.
        assert np.linalg.norm(SHAPES[shape].outline_xy - eye, axis=1).min() > 0.5, answer.reason
    # Each view is further round than the one before.
    bearings = np.unwrap([np.arctan2(v.T_map_base.y, v.T_map_base.x) for v in views(answers)])
    assert (np.diff(bearings) > 0).all()


@pytest.mark.parametrize("noise", [0.0, 0.004])
@pytest.mark.parametrize("shape", ["circle", "box", "large box"])
def test_the_camera_is_perpendicular_to_the_surface_at_the_leading_edge(shape, noise) -> None:
    outline = box(1.4, 1.0) if shape == "large box" else SHAPES[shape]
    answers = list(tour(outline, SurfaceNormalPlanner(), facing_centre(0.3, 1.5), noise))
    along = [v for v in views(answers) if v.reason.startswith("along the normal")]
    checked = 0
    for view in along:
        axis = camera_place(view.T_map_base, MOUNT).heading_xy
        np.testing.assert_allclose(view.normal_xy, -axis, atol=1e-9)
        # At a corner the patch holds some of both sides and its normal lies in between.
        walls_there = np.unique(np.round(outline.normals_near(view.looks_at_xy, 0.16), 6), axis=0)
        if shape != "circle" and len(walls_there) > 1:
            continue
        checked += 1
        assert np.degrees(np.arccos(np.clip(-walls_there @ axis, -1, 1))).min() < FACING_DEG
    assert checked >= 2


def test_the_distance_is_that_of_the_paper_where_the_object_fits() -> None:
    # Seen from 1.2 m above the floor, what stands there needs 0.9 m; what hangs higher does not.
    points = walls(circle(0.2).outline_xy)
    high = points[points[:, 2] > 0.35]
    for planner in PLANNERS.values():
        view = planner.next_view(planner_input(high, facing_centre(1.0, 1.2)))
        eye = camera_place(view.T_map_base, MOUNT).xy
        gap = np.linalg.norm(high[:, :2] - eye, axis=1).min()
        assert gap == pytest.approx(0.8, abs=0.04), view.reason


def test_a_large_object_is_viewed_from_the_fitting_distance() -> None:
    small, large = (
        views(tour(shape, CirclePlanner(), facing_centre(1.5, 3.0)))[-1]
        for shape in (box(0.5, 0.5), box(1.8, 1.8))
    )
    assert np.linalg.norm(camera_place(small.T_map_base, MOUNT).xy) < 0.8 + 0.36 + 0.1
    assert np.linalg.norm(camera_place(large.T_map_base, MOUNT).xy) > 0.8 + 1.28


def test_views_on_a_circle_face_its_centre_one_step_apart() -> None:
    known, base = walls(circle(0.3).outline_xy), facing_centre(0.5, 1.1)
    view = CirclePlanner(step_deg=40).next_view(planner_input(known, base))
    assert isinstance(view, NextView)
    eye = camera_place(view.T_map_base, MOUNT)
    towards = -eye.xy / np.linalg.norm(eye.xy)
    np.testing.assert_allclose(eye.heading_xy, towards, atol=0.01)
    # The step is that of the camera.
    before = camera_place(base, MOUNT)
    turn = np.arctan2(eye.y, eye.x) - np.arctan2(before.y, before.x)
    assert np.degrees(turn) == pytest.approx(40, abs=0.5)


@pytest.mark.parametrize("ahead", [-0.5, 0.3, 0.8])
@pytest.mark.parametrize("planner", [*PLANNERS.values(), ConfidencePlanner()])
def test_a_camera_ahead_of_the_axle_completes_the_orbit(planner, ahead: float) -> None:
    """Views at the camera's own place, or beside a refused one, would never end the round."""
    mount = RigidTransform.from_components([ahead, *MOUNT.translation[1:]], MOUNT.rotation)
    base = base_pose((1.2, 0.0), (0.0, 0.0), mount)
    asked = planner_input(
        walls(box(0.6, 0.6).outline_xy), base, visited=(base,), T_base_camera=mount
    )
    refused: list[NextView] = []
    while isinstance(view := planner.next_view(asked), NextView):
        refused.append(view)
        assert len(refused) < 20
        asked = replace(asked, unreachable=tuple(refused), given_up=tuple(refused))
    eyes = [camera_place(base, mount), *(camera_place(v.T_map_base, mount) for v in refused)]
    turns = np.degrees(np.diff(np.unwrap([np.arctan2(eye.y, eye.x) for eye in eyes])))
    assert (turns > 7).all()


@pytest.mark.parametrize("step", [0.0, 2.0, -30.0, 91.0, np.inf, np.nan])
def test_too_small_and_too_large_steps_are_refused(step) -> None:
    """A view that counts as reached at once would be chosen again and again."""
    with pytest.raises(InputError, match="step_deg must be 5 … 90 degrees, not"):
        CirclePlanner(step_deg=step)
    for name in ("corner_deg", "min_turn_deg"):
        with pytest.raises(InputError, match=name):
            SurfaceNormalPlanner(**{name: step})


@pytest.mark.parametrize("step", [MIN_STEP_DEG, MAX_STEP_DEG])
def test_allowed_steps_exceed_the_arrival_tolerance(step) -> None:
    """The step is longer than the arrival tolerance of the path follower."""
    known, base = walls(circle(0.3).outline_xy), facing_centre(0.5, 1.1)
    for planner in (CirclePlanner(step_deg=step), SurfaceNormalPlanner(corner_deg=step)):
        view = planner.next_view(planner_input(known, base))
        assert isinstance(view, NextView)
        assert PathFollower().velocity(base, view.T_map_base.xy[None], view.T_map_base, 0.2)


@pytest.mark.parametrize("planner", [*PLANNERS.values(), ConfidencePlanner()])
@pytest.mark.parametrize("count", [0, 1, 2, 5])
def test_a_nearly_empty_model_gives_a_view_or_a_reason(planner, count) -> None:
    points = np.array([[0.0, 0.0, 0.5], [0.02, 0, 0.5], [0, 0.02, 0.4], [0, 0, 0.3], [0, 0, 0.2]])
    answer = planner.next_view(planner_input(points[:count], PlanarPose(1.0, 0.2, 1.5)))
    if count == 0:
        assert answer == Finished(NOTHING_KNOWN)
    else:
        assert isinstance(answer, NextView)
        assert np.isfinite([answer.T_map_base.x, answer.T_map_base.y]).all()


@pytest.mark.parametrize("planner", PLANNERS.values())
def test_unreachable_views_are_skipped_until_all_are_tried(planner) -> None:
    known, base = walls(box(0.6, 0.6).outline_xy), facing_centre(0.0, 1.2)
    refused: list[NextView] = []
    for _ in range(20):
        asked = planner_input(
            known, base, visited=(base,), unreachable=tuple(refused), given_up=tuple(refused)
        )
        answer = planner.next_view(asked)
        if isinstance(answer, Finished):
            break
        refused.append(answer)
    assert answer.reason in (ALL_TRIED, AS_FAR_AS_POSSIBLE)
    assert 6 <= len(refused) <= 14
    bearings = np.unwrap([np.arctan2(v.T_map_base.y, v.T_map_base.x) for v in refused])
    assert (np.diff(bearings) > 0).all()


def test_observed_sides_are_not_visited_again() -> None:
    known = walls(box(0.6, 0.6).outline_xy)
    visited = tuple(facing_centre(a, 1.2) for a in np.radians(np.arange(-120, 1, 5)))
    first = CirclePlanner().next_view(planner_input(known, visited[-1], visited=visited))
    assert isinstance(first, NextView)
    refused: list[NextView] = [first]
    for _ in range(20):
        asked = planner_input(known, visited[-1], visited=visited, unreachable=tuple(refused))
        answer = CirclePlanner().next_view(asked)
        if isinstance(answer, Finished):
            break
        refused.append(answer)
    bearings = np.degrees([np.arctan2(v.T_map_base.y, v.T_map_base.x) for v in refused]) % 360
    assert ((bearings > 10) & (bearings < 245)).all()


def test_the_confidence_planner_stops_once_answers_are_confident() -> None:
    known, base = walls(circle(0.3).outline_xy), facing_centre(0.0, 1.1)
    planner = ConfidencePlanner()
    coverages = np.linspace(0.25, 0.7, 20)
    doubtful = tuple(Answer({"chair": 0.9, "sofa": 0.1}, share) for share in coverages)
    confident = tuple(replace(answer, confident=True) for answer in doubtful)
    done = planner.next_view(planner_input(known, base, answers=confident))
    assert isinstance(done, Finished)
    assert done.reason.startswith("the answer is confident: chair")
    assert isinstance(planner.next_view(planner_input(known, base, answers=doubtful)), NextView)
    once = (*doubtful[:-1], confident[-1])
    assert isinstance(planner.next_view(planner_input(known, base, answers=once)), NextView)
    assert planner.check_finished(planner_input(known, base, answers=once)) is None
