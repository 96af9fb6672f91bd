"""Sources of surfaces for simulated scans."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from circumspect.datasets.labelled_surfaces import OTHER, LabelledSurfaces, digest_of
from circumspect.datasets.object_set import ObjectSet
from circumspect.errors import InputError
from circumspect.furniture import CATEGORIES, make_furniture
from circumspect.furniture.other_things import OTHER_THINGS, make_other_thing
from circumspect.geometry import TriangleMesh, short_edge_triangles

FIRST_SEED = 1_000_000
"""First seed of procedural training furniture; the seeds of demo and benchmarks are lower."""
FIRST_HELD_BACK = 500_000
"""First seed of held-back procedural furniture."""
OTHER_SIZES = (0.3, 2.0)
"""Range of longest sides of procedural objects of other kinds [m]."""
INCH = 0.0254
"""Inch, the unit of most of ModelNet10's models [m]."""
SIZES: Mapping[str, tuple[tuple[float, float], tuple[float, float]]] = MappingProxyType(
    {
        "bathtub": ((0.40, 1.10), (1.20, 2.00)),
        "bed": ((0.40, 1.80), (1.70, 2.50)),
        "chair": ((0.60, 1.25), (0.40, 1.00)),
        "desk": ((0.65, 1.60), (0.80, 2.40)),
        "dresser": ((0.60, 1.50), (0.50, 1.90)),
        "monitor": ((0.25, 0.80), (0.30, 1.30)),
        "night_stand": ((0.40, 0.85), (0.35, 0.90)),
        "sofa": ((0.55, 1.10), (1.20, 3.40)),
        "table": ((0.30, 1.10), (0.45, 3.00)),
        "toilet": ((0.35, 1.00), (0.40, 0.90)),
    }
)
"""Ranges of height and longest horizontal side of real furniture by class [m], slightly wider than
in the Sweet Home 3D catalogues."""


@dataclass(frozen=True, eq=False)
class PointSurfaces:
    """Surfaces through the points of a set, in metres.

    Attributes:
        objects: The set; without `sides`, or for classes of unknown size, the scale is drawn.
    """

    objects: ObjectSet

    def mesh(self, index: int) -> TriangleMesh:
        """See `MeshSource.mesh`."""
        return short_edge_triangles(_placed_on_floor(self.points_in_metres(index)))

    @property
    def is_metric(self) -> NDArray[np.bool_]:
        """(n,) whether the size of each object is known."""
        found = self.objects.metric
        return np.zeros(len(self.objects), bool) if found is None else found

    def size_factors(self) -> NDArray[np.float64]:
        """(n, 2) range of scales of each object, see `metric_size.size_factors`."""
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
            label, np.ptp(points, axis=0), _generator(str(self.objects.names[index]))
        )


@dataclass(frozen=True)
class ProceduralSurfaces:
    """Procedural furniture of the ten categories, and objects of other kinds.

    Attributes:
        items: Category or kind, and seed, of each object.
    """

    items: tuple[tuple[str, int], ...]

    def mesh(self, index: int) -> TriangleMesh:
        """See `MeshSource.mesh`."""
        kind, seed = self.items[index]
        if kind in CATEGORIES:
            return make_furniture(kind, seed)
        mesh = make_other_thing(kind, seed)
        # Objects of other kinds have proportions, but no size.
        least, most = np.log(OTHER_SIZES)
        side = np.exp(_generator(f"{kind}-{seed}").uniform(least, most))
        points = mesh.vertices_xyz * side / np.ptp(mesh.vertices_xyz, axis=0).max()
        return TriangleMesh(_placed_on_floor(points), mesh.faces)


def of_point_set(objects: ObjectSet) -> LabelledSurfaces:
    """The objects of a labelled set of points.

    Raises:
        InputError: A class of unknown size has objects without a size in metres.
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
    """Texts of known sizes, which are not part of the digest of a set."""
    if objects.metric is None or objects.sides is None:
        return []
    return [repr(float(side)) for side in np.where(objects.metric, objects.sides, 0.0)]


def procedural(each: int, others: int, held_back: bool = False) -> LabelledSurfaces:
    """Procedural objects.

    Args:
        each: Number of objects of each of the ten categories.
        others: Number of objects of each other kind.
        held_back: Whether to use the seeds of held-back objects.
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


def _placed_on_floor(points_xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points moved onto z = 0, with the centre of their box on the z axis."""
    low, high = points_xyz.min(axis=0), points_xyz.max(axis=0)
    return points_xyz - [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]


def _generator(name: str) -> np.random.Generator:
    """Random generator that depends only on a name."""
    digest = hashlib.sha256(name.encode(errors="surrogatepass")).digest()
    return np.random.default_rng(np.frombuffer(digest, np.uint32))


def metres_per_unit(
    label: str, extent_xyz: NDArray[np.floating], rng: np.random.Generator
) -> float:
    """Choose a size for an object of unknown unit.

    Inches are used if the object then has a size of its class. Otherwise a scale is drawn
    log-uniformly from those with such a size.

    Args:
        label: Class of the object; one of `SIZES`.
        extent_xyz: (3,) sides in the unit of the file, z up.
        rng: Draws the scale.

    Returns:
        Metres per unit.
    """
    heights, sides = SIZES[label]
    height, side = float(extent_xyz[2]), float(max(extent_xyz[:2]))
    least = max(heights[0] / height, sides[0] / side)
    most = min(heights[1] / height, sides[1] / side)
    if least <= INCH <= most:
        return INCH
    if least > most:  # Unusual proportions: a compromise between both ranges.
        return float(np.sqrt(least * most))
    return float(np.exp(rng.uniform(np.log(least), np.log(most))))


def size_factors(label: str, extent_xyz: NDArray[np.floating]) -> tuple[float, float]:
    """Range of scales in which an object keeps a size of its class.

    Args:
        label: Class of the object; one of `SIZES`.
        extent_xyz: (3,) sides [m], z up.

    Returns:
        The smallest factor, at most 1, and the largest, at least 1.
    """
    heights, sides = SIZES[label]
    height, side = float(extent_xyz[2]), float(max(extent_xyz[:2]))
    least = max(heights[0] / height, sides[0] / side)
    most = min(heights[1] / height, sides[1] / side)
    return min(least, 1.0), max(most, 1.0)
