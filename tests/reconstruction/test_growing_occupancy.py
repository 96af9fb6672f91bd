"""Occupancy of a growing model equals that of the whole, whatever was traced before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from box_world import box_shots

from circumspect.errors import InputError
from circumspect.grid import FREE, CylindricalGrid, Grid, RectangularGrid
from circumspect.reconstruction import GrowingOccupancy, ObjectModel, occupancy


@pytest.fixture(scope="module")
def models() -> list[ObjectModel]:
    """A model after each of eight frames."""
    found = [ObjectModel()]
    for frame, mask in box_shots(8):
        found.append(found[-1].fused(frame, mask, frame.pose))
    return found[1:]


def grids_of(model: ObjectModel) -> tuple[CylindricalGrid, ...]:
    first = CylindricalGrid.fit(model.cloud())
    return first, first.rotated(0.3), replace(first, half_height=1.1 * first.half_height)


def states(growing: GrowingOccupancy, grids: tuple[Grid, ...], model: ObjectModel) -> np.ndarray:
    filled = growing.update(grids, model.cloud().points_xyz, model.rays)
    assert [one.grid for one in filled] == list(grids)
    return np.stack([one.states for one in filled])


def test_growing_occupancy_equals_that_of_the_whole_model(models: list[ObjectModel]) -> None:
    growing, grids = GrowingOccupancy(), grids_of(models[-1])
    for model in models:
        found = states(growing, grids, model)
        # A beam that passes a cell passes it in every later model, unless surface fills it.
        expected = [one.states for one in model.occupancies(grids)]
        np.testing.assert_array_equal(found, expected)


def test_moved_grids_and_other_rays_are_traced_again(models: list[ObjectModel]) -> None:
    growing, grids = GrowingOccupancy(), grids_of(models[-1])
    for model, wanted in [(models[6], grids), (models[7], grids[1:]), (models[2], grids[1:])]:
        expected = [one.states for one in model.occupancies(wanted)]
        np.testing.assert_array_equal(states(growing, wanted, model), expected)


def test_only_new_rays_are_traced(
    models: list[ObjectModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    growing, grids, traced = GrowingOccupancy(), grids_of(models[-1]), []
    trace_views = occupancy.trace_views

    def counted(views, origins, ends):
        traced.append(len(ends))
        return trace_views(views, origins, ends)

    monkeypatch.setattr(occupancy, "trace_views", counted)
    for model in [*models, models[-1]]:
        states(growing, grids, model)
    counts = np.diff([0, *(len(model.rays) for model in models)])
    assert traced == counts.tolist()


def test_a_new_fit_costs_a_bounded_number_of_rays(
    models: list[ObjectModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    model, grids = models[-1], grids_of(models[-1])
    most = len(model.rays) // 3
    monkeypatch.setattr(occupancy, "MAX_RETRACED_RAYS", most)
    few = states(GrowingOccupancy(), grids, model)
    whole = np.stack([one.states for one in model.occupancies(grids)])
    assert not ((few == FREE) & (whole != FREE)).any()
    assert (few == FREE).sum() > 0.8 * (whole == FREE).sum()


def test_a_cuboid_is_filled_like_a_cylinder(models: list[ObjectModel]) -> None:
    growing, grids = GrowingOccupancy(), (RectangularGrid((16, 16, 16), 0.8, (0.0, 0.0, 0.4)),)
    for model in models:
        expected = model.occupancy(grids[0]).states
        np.testing.assert_array_equal(states(growing, grids, model)[0], expected)


def test_views_have_one_axis(models: list[ObjectModel]) -> None:
    grid = grids_of(models[-1])[0]
    aside = replace(grid, centre_xyz=(1.0, 2.0, 0.0))
    with pytest.raises(InputError, match="one axis"):
        states(GrowingOccupancy(), (grid, aside), models[-1])
