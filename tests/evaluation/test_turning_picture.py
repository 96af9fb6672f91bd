"""An object that turns, in both kinds of grid."""

from __future__ import annotations

import numpy as np
import pytest

from circumspect.evaluation.grid_picture import changed_share, draw_turning, turned_grids
from circumspect.furniture import make_furniture

TURNS = (0.0, 45.0, 90.0, 97.0)


@pytest.fixture(scope="module")
def grids() -> dict:
    cloud = make_furniture("chair", 5).sampled(20_000, 0)
    return turned_grids(cloud, (32, 32, 32), TURNS)


def test_a_cylindrical_grid_shifts_and_a_rectangular_one_changes(grids: dict) -> None:
    def shares(kind: str) -> list[float]:
        turned = zip(grids[kind], TURNS, strict=True)
        return [changed_share(grids[kind][0], one, turn) for one, turn in turned]

    cylindrical, rectangular = shares("cylindrical"), shares("rectangular")
    assert cylindrical[0] == rectangular[0] == 0.0
    assert max(cylindrical[1:3]) < 0.01, "whole cells: rolled, but for points on a boundary"
    assert 0.01 < cylindrical[3] < 0.7, "a fraction of a cell"
    assert min(rectangular[1:]) > 0.5


def test_a_margin_makes_both_kinds_of_grid_larger() -> None:
    cloud = make_furniture("chair", 5).sampled(2000, 0)
    tight, wide = (turned_grids(cloud, (32, 32, 32), [0.0], margin) for margin in (1.0, 1.5))
    radii = [found["cylindrical"][0].grid.radius for found in (tight, wide)]
    widths = [found["rectangular"][0].grid.half_width for found in (tight, wide)]
    assert radii[1] / radii[0] == widths[1] / widths[0] == pytest.approx(1.5)


def test_each_turn_has_two_panels(grids: dict) -> None:
    figure = draw_turning(grids, TURNS)
    assert len(figure.axes) == 2 * len(TURNS)
    assert "45°" in figure.axes[1].get_title()
    assert figure.axes[0].get_ylabel() == "cylindrical: height [m]"
    shown = np.asarray(figure.axes[0].images[0].get_array())
    assert shown.shape == (32, 32)
