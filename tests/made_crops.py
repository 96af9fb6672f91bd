"""Made-up labelled crops: parts of furniture, standing in rooms, as files of their layout."""

from __future__ import annotations

import numpy as np

from circumspect.furniture import make_furniture
from circumspect.furniture.other_things import make_other_thing


def crop(kind, seed, points=1500, one_sided=True):
    """(n, 3) points of a piece of furniture somewhere in a room, most of them on one side."""
    mesh = make_furniture(kind, seed)
    cloud = mesh.sampled(2 * points if one_sided else points, seed).points_xyz
    if one_sided:
        order = np.argsort(cloud[:, 1] + np.random.default_rng(seed).normal(0, 0.2, len(cloud)))
        cloud = cloud[order[:points]]
    turn = np.random.default_rng(seed + 1).uniform(0, 2 * np.pi)
    cosine, sine = np.cos(turn), np.sin(turn)
    matrix = np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    return cloud @ matrix + [2.0, -3.0, 0.0]


def other_crop(kind="car", seed=0, side=0.8):
    """(n, 3) points of a thing of no class."""
    cloud = make_other_thing(kind, seed).sampled(1500, seed).points_xyz
    return cloud / np.ptp(cloud, axis=0).max() * side


def arrays_of(clouds, labels, scenes, **others):
    """The arrays of a file."""
    return {
        "points": np.concatenate(clouds).astype(np.float32),
        "offsets": np.cumsum([0, *map(len, clouds)]),
        "label": np.array(labels, dtype=str),
        "scene": np.array(scenes, dtype=str),
        **others,
    }


def little_rooms():
    """Two rooms with chairs, a table and a sofa, a thing of another kind and an ambiguous one."""
    labels = ["chair", "chair", "table", "sofa", "toilet", "lamp", "armchair"]
    clouds = [crop(kind, 40 + k) for k, kind in enumerate(labels[:5])]
    clouds += [other_crop(), crop("sofa", 50)]
    scenes = ["kitchen", "office", "kitchen", "office", "office", "kitchen", "office"]
    return arrays_of(clouds, labels, scenes)


def write_crops(path, arrays=None):
    """Write a file of labelled crops."""
    np.savez_compressed(path, **(little_rooms() if arrays is None else arrays))
    return path
