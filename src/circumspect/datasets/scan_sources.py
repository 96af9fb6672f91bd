"""Where the surfaces come from that simulated scans are made of."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.labelled_surfaces import OTHER, LabelledSurfaces, digest_of
from circumspect.datasets.metric_size import SIZES, metres_per_unit, size_factors
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.furniture.other_things import OTHER_THINGS, make_other_thing
from circumspect.geometry import TriangleMesh, short_edge_triangles

FIRST_SEED = 1_000_000
"""Of procedural furniture that trains; the demo's and the benchmarks' seeds lie below …"""
FIRST_HELD_BACK = 500_000
"""… and so do those of the furniture that is held back."""
OTHER_SIZES = (0.3, 2.0)
"""Longest sides of procedural things of other kinds [m]."""


@dataclass(frozen=True, eq=False)
class PointSurfaces:
    """Surfaces through the points of a set, in metres.

    Attributes:
        objects: The set; without `sides`, or of classes without a known size, the scale is drawn.
    """

    objects: ObjectSet

    def mesh(self, index: int) -> TriangleMesh:
        """See `MeshSource.mesh`."""
        return short_edge_triangles(_standing(self.points_in_metres(index)))

    @property
    def is_metric(self) -> NDArray[np.bool_]:
        """(n,) whether the size of each object is known."""
        found = self.objects.metric
        return np.zeros(len(self.objects), bool) if found is None else found

    def size_factors(self) -> NDArray[np.float64]:
        """(n, 2) by how much each object may shrink and grow, see `metric_size.size_factors`."""
        return np.array([self._factors(index) for index in range(len(self.objects))]).reshape(-1, 2)

    def _factors(self, index: int) -> tuple[float, float]:
        if self.is_metric[index]:
            return 1.0, 1.0
        label = self.objects.classes[self.objects.labels[index]]
        return size_factors(label, np.ptp(self.points_in_metres(index), axis=0))

    def points_in_metres(self, index: int) -> NDArray[np.float64]:
        """(p, 3) points of one object [m]."""
        points = self.objects.points_xyz[index].astype(np.float64)
        if self.objects.sides is not None:
            points = points / np.ptp(points, axis=0).max() * self.objects.sides[index]
        if self.is_metric[index]:
            return points
        label = self.objects.classes[self.objects.labels[index]]
        return points * metres_per_unit(
            label, np.ptp(points, axis=0), _chance(str(self.objects.names[index]))
        )


@dataclass(frozen=True)
class ProceduralSurfaces:
    """Procedural furniture of the ten categories, and things of other kinds.

    Attributes:
        items: Category or kind, and seed.
    """

    items: tuple[tuple[str, int], ...]

    def mesh(self, index: int) -> TriangleMesh:
        """See `MeshSource.mesh`."""
        kind, seed = self.items[index]
        if kind in CATEGORIES:
            return make_furniture(kind, seed)
        mesh = make_other_thing(kind, seed)
        # These have proportions, but no size of their own.
        least, most = np.log(OTHER_SIZES)
        side = np.exp(_chance(f"{kind}-{seed}").uniform(least, most))
        points = mesh.vertices_xyz * side / np.ptp(mesh.vertices_xyz, axis=0).max()
        return TriangleMesh(_standing(points), mesh.faces)


def of_point_set(objects: ObjectSet) -> LabelledSurfaces:
    """The objects of a labelled set of points.

    Raises:
        InputError: A class of unknown size, with objects whose files give no size in metres.
    """
    labels = np.array([objects.classes[label] for label in objects.labels])
    source = PointSurfaces(objects)
    if unknown := sorted(set(labels[~source.is_metric].tolist()) - set(SIZES)):
        raise InputError(
            f"no sizes are known for {', '.join(unknown)}; known: {', '.join(SIZES)}; files in "
            "metres (GLB, glTF) have their own"
        )
    return LabelledSurfaces(
        source, np.arange(len(objects)), labels, objects.names,
        digest_of(["points 2", objects.digest, *_sizes(objects)]), source.size_factors(),
    )  # fmt: skip


def _sizes(objects: ObjectSet) -> list[str]:
    """Known sizes, which the digest of a set leaves out."""
    if objects.metric is None or objects.sides is None:
        return []
    return [repr(float(side)) for side in np.where(objects.metric, objects.sides, 0.0)]


def procedural(each: int, others: int, held_back: bool = False) -> LabelledSurfaces:
    """Procedural objects.

    Args:
        each: Of each of the ten categories.
        others: Of each other kind.
        held_back: Other seeds than those that train.
    """
    first = FIRST_HELD_BACK if held_back else FIRST_SEED
    kinds = [(kind, each) for kind in CATEGORIES] + [(kind, others) for kind in OTHER_THINGS]
    items = tuple((kind, first + number) for kind, count in kinds for number in range(count))
    names = [f"procedural_{kind}_{seed}" for kind, seed in items]
    labels = [kind if kind in CATEGORIES else OTHER for kind, _ in items]
    return LabelledSurfaces(
        ProceduralSurfaces(items), np.arange(len(items)), np.array(labels, np.str_),
        np.array(names, np.str_), digest_of(["procedural 1", *names]),
    )  # fmt: skip


def _standing(points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points moved onto z = 0, the middle of their box on the z axis."""
    low, high = points_xyz.min(axis=0), points_xyz.max(axis=0)
    return points_xyz - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]


def _chance(name: str) -> np.random.Generator:
    """Chance that depends on a name alone."""
    digest = hashlib.sha256(name.encode(errors="surrogatepass")).digest()
    return np.random.default_rng(np.frombuffer(digest, np.uint32))
