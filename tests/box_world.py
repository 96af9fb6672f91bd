"""A box on a floor, photographed from all round, for tests of the object model."""

from __future__ import annotations

import numpy as np

from circumspect.geometry import PinholeCamera, TriangleMesh
from circumspect.reconstruction import ModelSettings, ObjectModel
from circumspect.sensing import DepthNoise
from circumspect.simulation import Orbit, Scene, SimulatedCamera, block

CAMERA = PinholeCamera(320, 240, 285.0, 285.0, 159.5, 119.5)
LOW, HIGH = (-0.25, -0.35, 0.0), (0.25, 0.35, 0.6)
BOX = block(LOW, HIGH)
SEEN_AREA = 2 * 0.6 * (0.5 + 0.7) + 0.5 * 0.7


def box_shots(count: int, noise: DepthNoise | None = None, mesh: TriangleMesh = BOX):
    """(frame, object mask) all round a box on a floor; the mask is the truth."""
    orbit = Orbit.around(mesh, CAMERA, start=0.2)
    camera = SimulatedCamera(Scene.with_object(mesh), lambda: orbit.station(0), CAMERA, noise)
    for index in range(count):
        station = orbit.station(2 * np.pi * index / count)
        frame = camera.photograph(station)
        yield frame, (camera.truth(station).surface == 0) & frame.valid


def fused(shots) -> ObjectModel:
    model = ObjectModel(ModelSettings(voxel=0.008))
    for frame, mask in shots:
        model = model.fused(frame, mask, frame.pose)
    return model
