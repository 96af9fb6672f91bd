"""A reader of your own: circumspect classify chair.asc, or FILE --reader own_reader:read_asc."""

from pathlib import Path

import numpy as np

from circumspect.geometry import PointCloud


def read_asc(path: Path) -> PointCloud:
    """Points of a text file with x;y;z in each line, in any unit."""
    return PointCloud(np.loadtxt(path, delimiter=";", usecols=(0, 1, 2), ndmin=2))
