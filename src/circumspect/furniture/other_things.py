"""Things of none of the ten categories, which a classifier should report as unknown."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from circumspect.furniture.outlines import ellipse, rounded_rectangle
from circumspect.furniture.placement import (
    around,
    both_sides,
    joined,
    moved,
    placed_on_floor,
    turned,
)
from circumspect.furniture.primitives import (
    box,
    cylinder,
    leg,
    prism,
    revolved,
    rounded_box,
    stacked,
    tube,
)
from circumspect.geometry import TriangleMesh

Chance = np.random.Generator


def make_other_thing(kind: str, seed: int) -> TriangleMesh:
    """One thing with proportions of its own, on z = 0 about the z axis.

    Args:
        kind: One of `OTHER_THINGS`.
        seed: Not negative; the same seed gives the same thing.

    Raises:
        KeyError: No such kind.
    """
    number = list(OTHER_THINGS).index(kind) if kind in OTHER_THINGS else -1
    if number < 0:
        raise KeyError(kind)
    return placed_on_floor(OTHER_THINGS[kind](np.random.default_rng([100 + number, seed])))


def _airplane(rng: Chance) -> TriangleMesh:
    length, width = rng.uniform(1.2, 1.8), rng.uniform(0.14, 0.24)
    shares = np.array([0.05, 0.7, 1.0, 1.0, 0.8, 0.15])
    profile = np.stack([shares * width / 2, np.array([0, 0.08, 0.2, 0.6, 0.8, 1]) * length], axis=1)
    hull = turned(revolved(profile), -np.pi / 2, "x")
    span, chord, sweep = rng.uniform(1.0, 1.8), rng.uniform(0.18, 0.35), rng.uniform(0, 0.4)
    wing = np.array([[0, 0], [span / 2, sweep], [span / 2, sweep + chord / 2], [0, chord]])
    wings = both_sides(prism(wing, 0.03, (0, 0.4 * length, 0)))
    tail = both_sides(prism(wing * 0.35, 0.02, (0, 0.85 * length, 0)))
    fin = turned(prism(wing * 0.35, 0.02, (0, 0.85 * length, 0)), -np.pi / 2, "y")
    return joined([hull, wings, tail, fin])


def _archway(rng: Chance) -> TriangleMesh:
    wide, tall, thick = rng.uniform(0.8, 1.6), rng.uniform(1.2, 2.2), rng.uniform(0.15, 0.4)
    pillar = box((thick, thick, tall), ((wide + thick) / 2, 0, 0))
    beam = box((wide + 2 * thick, thick, thick), (0, 0, tall))
    return joined([both_sides(pillar), beam])


def _ball(rng: Chance) -> TriangleMesh:
    turn = np.linspace(-np.pi / 2, np.pi / 2, 13)
    flat = rng.uniform(0.75, 1.3)
    return revolved(np.stack([np.maximum(np.cos(turn), 0.01), flat * np.sin(turn)], axis=1))


def _bottle(rng: Chance) -> TriangleMesh:
    neck, shoulder = rng.uniform(0.2, 0.45), rng.uniform(0.5, 0.75)
    tall = rng.uniform(2.2, 4.0)
    profile = [(0.9, 0), (1, 0.1), (1, shoulder * tall), (neck, (shoulder + 0.15) * tall)]
    return revolved([*profile, (neck, tall), (1.2 * neck, tall), (1.2 * neck, 1.03 * tall)])


def _car(rng: Chance) -> TriangleMesh:
    long, wide = rng.uniform(3.6, 4.8), rng.uniform(1.6, 1.9)
    body = rounded_box((wide, long, rng.uniform(0.5, 0.7)), (0, 0, 0.35), 0.15)
    sill = rounded_rectangle(wide, 0.6 * long, 0.1)
    roof = rounded_rectangle(0.8 * wide, rng.uniform(0.3, 0.45) * long, 0.1)
    middle = (0, rng.uniform(-0.05, 0.1) * long, 0.9)
    cabin = stacked([sill, roof], [0, rng.uniform(0.45, 0.65)], middle)
    wheel = turned(cylinder(0.65, 0.2), np.pi / 2, "y")
    places = [(0.4 * wide, y * long, 0.33) for y in (-0.32, 0.3)]
    return joined([body, cabin, both_sides(joined([moved(wheel, at) for at in places]))])


def _cone(rng: Chance) -> TriangleMesh:
    foot, tall = rng.uniform(0.35, 0.55), rng.uniform(0.5, 1.0)
    top = rng.uniform(0.02, 0.06)
    plate = box((foot, foot, 0.04))
    return joined([plate, revolved([(0.42 * foot, 0.04), (top, tall)])])


def _floor_lamp(rng: Chance) -> TriangleMesh:
    tall, shade = rng.uniform(1.3, 1.8), rng.uniform(0.3, 0.55)
    foot = cylinder(rng.uniform(0.22, 0.35), 0.03)
    lower, upper = shade / 2, shade / 2 * rng.uniform(0.4, 1.0)
    skirt = revolved([(lower, tall - rng.uniform(0.2, 0.4)), (upper, tall)])
    return joined([foot, cylinder(0.03, tall - 0.05), skirt])


def _ladder(rng: Chance) -> TriangleMesh:
    wide, tall, rungs = rng.uniform(0.3, 0.5), rng.uniform(1.6, 2.6), int(rng.integers(6, 11))
    rail = box((0.05, 0.07, tall), (wide / 2, 0, 0))
    steps = [box((wide, 0.04, 0.04), (0, 0, (k + 0.7) * tall / rungs)) for k in range(rungs)]
    side = turned(joined([both_sides(rail), *steps]), rng.uniform(0.15, 0.3), "x", (0, 0, tall))
    return both_sides(side, "y") if rng.random() < 0.5 else side


def _person(rng: Chance) -> TriangleMesh:
    tall = rng.uniform(1.5, 1.95)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 9)
    skull = np.stack([0.095 * np.maximum(np.cos(turn), 0.02), 0.12 * np.sin(turn)], axis=1)
    hip, neck, apart = 0.48 * tall, 0.84 * tall, rng.uniform(0.08, 0.2)
    chest = stacked(
        [ellipse(0.32, 0.2), ellipse(0.42, 0.24), ellipse(0.2, 0.16)],
        [hip, 0.78 * tall, neck],
    )
    leg_ = leg((apart, 0, 0), (0.09, 0, hip), 0.1, 0.16, 8)
    raised = rng.uniform(0.0, 1.2)
    hand = 0.2 + 0.6 * np.sin(raised), 0.0, 0.8 * tall - 0.6 * np.cos(raised)
    arm = tube([(0.2, 0, 0.8 * tall), hand], 0.08)
    head = moved(revolved(skull), (0, 0, tall - 0.12))
    throat = cylinder(0.1, 0.06, (0, 0, neck))
    return joined([chest, throat, head, both_sides(leg_), both_sides(arm)])


def _potted_plant(rng: Chance) -> TriangleMesh:
    wide, tall = rng.uniform(0.25, 0.4), rng.uniform(0.25, 0.4)
    pot = revolved([(0.35 * wide, 0), (0.5 * wide, tall)])
    leaves = []
    for _ in range(int(rng.integers(9, 18))):
        reach, rise = rng.uniform(0.2, 0.6), rng.uniform(0.2, 0.9)
        path = [(0, 0, tall), (0.5 * reach, 0, tall + rise), (reach, 0, tall + 0.8 * rise)]
        leaf = tube(path, np.array([0.02, 0.09, 0.01]))
        leaves.append(turned(leaf, rng.uniform(0, 2 * np.pi)))
    return joined([pot, *leaves])


def _ring(rng: Chance) -> TriangleMesh:
    angles = np.linspace(0, 2 * np.pi, 33)
    path = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    lying = tube(path, rng.uniform(0.2, 0.6))
    return turned(lying, np.pi / 2, "x") if rng.random() < 0.5 else lying


def _stairs(rng: Chance) -> TriangleMesh:
    steps, wide = int(rng.integers(3, 9)), rng.uniform(0.6, 1.2)
    rise, going = rng.uniform(0.15, 0.2), rng.uniform(0.24, 0.32)
    return joined([box((wide, going, (k + 1) * rise), (0, k * going, 0)) for k in range(steps)])


def _windmill(rng: Chance) -> TriangleMesh:
    tall, reach = rng.uniform(1.6, 2.4), rng.uniform(0.6, 1.0)
    tower = revolved([(0.3, 0), (0.18, tall), (0.02, tall + 0.2)])
    sail = box((0.2 * reach, 0.02, reach), (0.1 * reach, 0, 0.05))
    upright = turned(around(turned(sail, np.pi / 2, "x"), 4), np.pi / 2, "x")
    return joined([tower, moved(upright, (0, -0.3, tall - 0.1))])


OTHER_THINGS: dict[str, Callable[[Chance], TriangleMesh]] = {
    "airplane": _airplane,
    "archway": _archway,
    "ball": _ball,
    "bottle": _bottle,
    "car": _car,
    "cone": _cone,
    "floor_lamp": _floor_lamp,
    "ladder": _ladder,
    "person": _person,
    "potted_plant": _potted_plant,
    "ring": _ring,
    "stairs": _stairs,
    "windmill": _windmill,
}
