"""What is wrong with a cloud now and then: a part is missing, points float about, the axis leans.

Networks that are to bear this are trained on some of it; what they are measured by is in
`corruption`, which has other kinds, measures and chances.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Samples = NDArray[np.float32]
MISSING = (0.1, 0.5)
"""Share of the samples that a cut or holes take."""
MOST_HOLES = 4
MOST_STRAYS = 0.01
"""Per sample; a filled cloud has several samples for each point that was measured."""
MOST_LEAN_DEG = 10.0


def damaged(samples: Samples, rng: np.random.Generator) -> Samples:
    """An object's samples after one of four things went wrong, each as likely as the others.

    Args:
        samples: (n, 3) in units of the scale, the centre at the origin, z up; n at least 1.
        rng: Source of all chance.

    Returns:
        (m, 3), m at least 1; neither centred nor scaled anew.
    """
    damage = (_cut, _holed, _strewn, _leaning)[rng.integers(4)]
    return damage(samples, rng)


def _cut(samples: Samples, rng: np.random.Generator) -> Samples:
    """Nothing is left beyond a plane of any direction."""
    direction = rng.normal(size=3)
    along = samples @ (direction / np.linalg.norm(direction)).astype(np.float32)
    return samples[along <= np.quantile(along, 1 - rng.uniform(*MISSING))]


def _holed(samples: Samples, rng: np.random.Generator) -> Samples:
    """Balls of equal numbers of samples are missing."""
    holes = int(rng.integers(1, MOST_HOLES + 1))
    size = int(len(samples) * rng.uniform(*MISSING) / holes)
    for _ in range(holes):
        away = ((samples - samples[rng.integers(len(samples))]) ** 2).sum(axis=1)
        # In their order: evenly spread points come first.
        samples = samples[np.sort(np.argsort(away)[size:])]
    return samples


def _strewn(samples: Samples, rng: np.random.Generator) -> Samples:
    """Points float in the ball round the object."""
    count = round(len(samples) * rng.uniform(0, MOST_STRAYS))
    radius = np.linalg.norm(samples, axis=1).max()
    directions = rng.normal(size=(count, 3))
    away = radius * np.cbrt(rng.random((count, 1)))
    strays = away * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    return np.concatenate([samples, strays.astype(np.float32)])


def _leaning(samples: Samples, rng: np.random.Generator) -> Samples:
    """Turned about a level axis: the way it faces stays."""
    heading, lean = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(0, MOST_LEAN_DEG))
    turn = Rotation.from_rotvec(lean * np.array([np.cos(heading), np.sin(heading), 0.0]))
    return samples @ turn.as_matrix().T.astype(np.float32)
