"""Grids with sub-cell offsets."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circumspect.classification import Classifier, GridSpec
from circumspect.classification.grid_spec import MAX_DITHER_CELLS
from circumspect.classification.input_spec import turned
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.geometry import PointCloud

VIEWS = st.integers(1, 64)
SHAPES = st.tuples(st.integers(8, 48), st.integers(1, 48), st.integers(8, 48))


def dithered(margin=1.1, views=8, shape=(32, 32, 32)):
    return GridSpec(shape=shape, azimuth_views=views, margin=margin, dithered=True)


@given(VIEWS, SHAPES, st.sampled_from(CATEGORIES), st.integers(0, 5))
def test_every_grid_holds_the_whole_object(views, shape, category, variant):
    cloud = make_furniture(category, variant).sampled(2000, 0)
    least = 1.0 / ((1.0 - MAX_DITHER_CELLS / 2 / shape[0]) * (1.0 - 1.0 / shape[2]))
    input_spec = dithered(least, views, shape)
    for grid in input_spec.all_bounds(input_spec.bounds(cloud)):
        x, y, z = (cloud.points_xyz - grid.centre_xyz).T
        assert np.hypot(x, y).max() <= grid.radius * (1 + 1e-9)
        assert np.abs(z).max() <= grid.half_height * (1 + 1e-9)
    with pytest.raises(InputError, match="to hold the whole object"):
        dithered(least - 1e-6, views, shape)


@given(VIEWS, SHAPES)
def test_all_grids_have_different_offsets(views, shape):
    input_spec = dithered(4.0, views, shape)
    first, *further = input_spec.all_bounds(input_spec.unit_bounds)
    assert first == input_spec.unit_bounds
    cells = [(g.centre_xyz[2] * shape[2] / (2 * g.half_height)) for g in (first, *further)]
    sizes = [(g.radius - 1.0) * shape[0] / MAX_DITHER_CELLS for g in (first, *further)]
    for offsets in (cells, sizes):
        gaps = np.diff(np.sort(np.append(offsets, min(offsets) + 1.0)))
        # As far apart as the recurrence puts up to 64 at worst.
        assert gaps.min() > 0.08 / views
        assert gaps.max() < 4.3 / views
        assert np.abs(offsets).max() <= 0.5 + 1e-9
    assert all(g.half_height == pytest.approx(g.radius) for g in further)


def test_an_object_that_turns_by_whole_cells_rolls_all_of_its_grids():
    cloud = make_furniture("desk", 3).sampled(20_000, 0)
    input_spec = dithered()
    still, moved = input_spec.grids(cloud, [0.0, 5 * 2 * np.pi / 32])
    assert (np.roll(still, 5, axis=2) != moved).mean() < 1e-4


@given(st.floats(0, 7))
def test_clouds_are_turned_as_grids_are(yaw):
    cloud = make_furniture("chair", 2).sampled(20_000, 0)
    input_spec = dithered()
    about = PointCloud(cloud.points_xyz - input_spec.bounds(cloud).centre_xyz)
    expected = input_spec.grids(PointCloud(turned(about.points_xyz, yaw)))[0]
    assert (input_spec.grids(about, [yaw])[0] != expected).mean() < 1e-3


@given(st.integers(1, 8), st.booleans(), st.lists(st.floats(-7, 7), min_size=1, max_size=3))
def test_grids_of_a_input_spec_equal_those_filled_one_by_one(views, moved, yaws):
    cloud = make_furniture("chair", 2).sampled(3000, 0)
    input_spec = replace(dithered(views=views), dithered=moved, fill_below=1)
    bounds = input_spec.bounds(cloud)
    axis = np.array([*bounds.centre_xyz[:2], 0.0])
    for yaw, occupied in zip(yaws, input_spec.grids(cloud, yaws), strict=True):
        points = turned(cloud.points_xyz - axis, yaw)
        for view, grid in zip(occupied, input_spec.all_bounds(bounds), strict=True):
            about = grid.recentred((0.0, 0.0, grid.centre_xyz[2]))
            # Matrix products round otherwise than the kernel.
            assert (about.hits(points).occupied != view).sum() <= 2
    still = input_spec.grids(cloud)[0]
    for view, grid in zip(still, input_spec.all_bounds(bounds), strict=True):
        assert np.array_equal(grid.hits(cloud).occupied, view)


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"margin": 1.0}, "a margin of 1.066, not 1, to hold the whole object"),
        ({"kind": "rectangular", "azimuth_views": 1}, "--azimuth-views and --dithered"),
        ({"dithered": 1}, "true or false"),
        ({"shape": (1, 8, 8)}, "one ring or one layer"),
        ({"shape": (8, 8, 1)}, "one ring or one layer"),
    ],
)
def test_settings_that_can_not_be_dithered_are_refused(settings, says):
    with pytest.raises(InputError, match=says):
        GridSpec(**{"azimuth_views": 8, "margin": 1.1, "dithered": True, **settings})


def test_answers_depend_less_on_cell_offsets():
    """The size and place of a scan are uncertain by millimetres, a good part of a cell."""
    classifier = Classifier.load("modelnet10")
    apart = {}
    for name, input_spec in (
        ("turned", GridSpec(azimuth_views=8, margin=1.1)),
        ("all", dithered()),
    ):
        spreads = []
        for category, variant in (("night_stand", 70006), ("table", 70003), ("monitor", 70019)):
            cloud = make_furniture(category, variant).sampled(30_000, 0)
            sizes = 1.1 * (1.0 + np.linspace(-0.5, 0.5, 9) / 32)
            grids = [input_spec.with_margin(float(size)).grids(cloud)[0] for size in sizes]
            scores = classifier.scores(np.stack(grids)[:, :, None])
            spreads.append(scores.std(axis=0).mean())
        apart[name] = np.mean(spreads)
    assert apart["all"] < 0.8 * apart["turned"], apart
