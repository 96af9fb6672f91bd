from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.geometry import TriangleMesh
from circumspect.simulation import Scene, Surface, block, cylinder, floor
from circumspect.simulation.scene import CELL_M, footprint_boxes


def boxes_of(*meshes: TriangleMesh, height: float = 1.2) -> np.ndarray:
    return footprint_boxes(Scene(tuple(Surface("thing", mesh) for mesh in meshes)), height)


def covered(boxes: np.ndarray, points_xy: np.ndarray, slack: float = 0.0) -> np.ndarray:
    low, high = boxes[:, None, :2] - slack, boxes[:, None, 2:] + slack
    return ((points_xy >= low) & (points_xy <= high)).all(axis=2).any(axis=0)


@settings(max_examples=20)
@given(turn=st.floats(0, 3), length=st.floats(0.1, 2.0))
def test_boxes_cover_a_rotated_wall_tightly(turn: float, length: float) -> None:
    c, s = np.cos(turn), np.sin(turn)
    plain = block((-length, -0.05, 0.0), (length, 0.05, 2.0))
    xy = plain.vertices_xyz[:, :2] @ np.array([[c, s], [-s, c]])
    wall = TriangleMesh(np.column_stack([xy, plain.vertices_xyz[:, 2]]), plain.faces)
    boxes = boxes_of(wall)
    # Sides of the wall are covered all along; a ray of chance may miss the corner of a cell.
    along = np.linspace(-length, length, 400)
    sides = np.concatenate([np.column_stack([along, np.full(400, y)]) for y in (-0.05, 0.05)])
    assert covered(boxes, sides @ np.array([[c, s], [-s, c]]), 0.02).all()
    corners = boxes.reshape(-1, 2) @ np.array([[c, -s], [s, c]])
    assert np.abs(corners[:, 1]).max() < 0.05 + 1.5 * CELL_M
    assert np.abs(corners[:, 0]).max() < length + 1.5 * CELL_M


def test_boxes_do_not_overlap() -> None:
    boxes = boxes_of(cylinder(0.4, 0.0, 1.0))
    middles = (boxes[:, :2] + boxes[:, 2:]) / 2
    inside = ((middles[None] > boxes[:, None, :2]) & (middles[None] < boxes[:, None, 2:])).all(2)
    assert inside.sum() == len(boxes)


def test_only_surfaces_within_the_height_of_the_robot_count() -> None:
    rug, lamp = block((0, 0, 0), (1, 1, 0.02)), block((0, 0, 1.5), (1, 1, 1.6))
    assert len(boxes_of(rug, lamp)) == 0
    assert len(boxes_of(lamp, height=1.7)) > 0


def test_the_floor_is_no_obstacle() -> None:
    scene = Scene((Surface("floor", floor(2.0)), Surface("floor", block((0, 0, 0), (1, 1, 1)))))
    assert footprint_boxes(scene, 1.0).shape == (0, 4)
