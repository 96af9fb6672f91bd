"""Flat printed plates: tags, a robot's top, calibration boards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry.frozen_array import ReadOnlyArrays
from circumspect.localization.tag_mount import MODULES, tag_picture

BLACK, WHITE = 0.06, 0.88
"""Reflectance of printed black and of white paper."""


@dataclass(frozen=True, eq=False)
class Plate(ReadOnlyArrays):
    """A rectangle in the plane z = 0 of its own frame, with its centre at the origin.

    Attributes:
        reflectance: (rows, columns) 0 … 1, NaN where transparent; row 0 is at the largest y, column
            0 at the smallest x. Its pixels have sharp edges.
        width: Size along x [m].
        height: Size along y [m].
        rays: Rays per pixel of an image; 16 for edges that are measured, 4 for others.

    Raises:
        InputError: The picture or the size is empty, or the number of rays is not 1, 2, 4, 8 or 16.
    """

    reflectance: NDArray[np.float32]
    width: float
    height: float
    rays: int = 16

    def __post_init__(self) -> None:
        picture = np.array(self.reflectance, dtype=np.float32)
        if picture.ndim != 2 or picture.size == 0 or not (self.width > 0 and self.height > 0):
            raise InputError(
                f"a plate is a picture with a size, not {picture.shape}, "
                f"{self.width} x {self.height} m"
            )
        if self.rays not in (1, 2, 4, 8, 16):
            raise InputError(f"rays through a pixel are 1, 2, 4, 8 or 16, not {self.rays}")
        picture.flags.writeable = False
        object.__setattr__(self, "reflectance", picture)

    @classmethod
    def tag(cls, tag_id: int, size: float, border: int = 1) -> Plate:
        """A printed tag of the family 36h11.

        Args:
            tag_id: Number of the tag in its family.
            size: Side of the black square [m].
            border: Width of the white border, in modules.

        Raises:
            InputError: There is no such tag.
            MissingExtraError: OpenCV is not installed.
        """
        side = size * (MODULES + 2 * border) / MODULES
        return cls.printed(tag_picture(tag_id, border), side, side)

    @classmethod
    def printed(cls, picture: NDArray[np.uint8], width: float, height: float) -> Plate:
        """A plate of paper with printed grey levels."""
        light = BLACK + (WHITE - BLACK) * (picture / 255)
        return cls(light.astype(np.float32), width, height)

    @classmethod
    def disc(cls, radius: float, reflectance: float, pixels: int = 128) -> Plate:
        """A round plate of uniform grey."""
        along = (np.arange(pixels) + 0.5) / pixels * 2 - 1
        inside = along**2 + along[:, None] ** 2 <= 1
        return cls(
            np.where(inside, np.float32(reflectance), np.float32(np.nan)), 2 * radius, 2 * radius, 4
        )

    @property
    def outline_xyz(self) -> NDArray[np.float64]:
        """(n, 3) [m] points on the edge."""
        along = np.linspace(-0.5, 0.5, 9)
        ones = np.full(9, 0.5)
        x = np.concatenate([along, ones, -along, -ones]) * self.width
        y = np.concatenate([-ones, along, ones, -along]) * self.height
        return np.column_stack([x, y, np.zeros(len(x))])
