"""One frame that the scene map is made of."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.mapping.wheels import Passage
from circumspect.registration import CompactSurface, FreeSpace, Scan, ScanSurface
from circumspect.sensing import RgbdFrame


@dataclass(frozen=True, eq=False)
class Keyframe:
    """See the file's text.

    Attributes:
        number: Its name for good.
        stamp: When it was taken [s].
        T_map_camera: Where it was taken from, by what is known now.
        compact: What it shows, see `surface`.
        space: What it shows to be empty.
        covariance: (6, 6) of changes of the pose, optical frame, since the first keyframe.
        passage: How the camera came there.
        parent: The keyframe that it was placed by; None for the first.
        since_parent: (6, 6) covariance of its pose if that one's were known exactly; of the first
            one its own.
        T_base_camera: The mount; None where not known.
    """

    number: int
    stamp: float
    T_map_camera: RigidTransform
    compact: CompactSurface
    space: FreeSpace
    covariance: NDArray[np.floating]
    passage: Passage
    parent: int | None
    since_parent: NDArray[np.floating]
    T_base_camera: RigidTransform | None = None

    @classmethod
    def of(
        cls,
        number: int,
        T_map_camera: RigidTransform,
        covariance: NDArray[np.floating],
        scan: Scan,
        frame: RgbdFrame,
        passage: Passage,
        parent: int | None = None,
        since_parent: NDArray[np.floating] | None = None,
    ) -> Keyframe:
        """Look closely at a frame; see the attributes."""
        surface, mount = ScanSurface.from_scan(scan), frame.T_base_camera
        if mount is not None:
            surface = surface.with_vertical_floor_normals(T_map_camera)
        since = covariance if since_parent is None else since_parent
        return cls(
            number, frame.stamp, T_map_camera, CompactSurface.from_surface(surface),
            FreeSpace.from_frame(frame), covariance, passage, parent, since, mount,
        )  # fmt: skip

    @property
    def surface(self) -> ScanSurface:
        """What it shows."""
        return self.compact.expanded()

    def shows(
        self, points_xyz: NDArray[np.float64], normals_xyz: NDArray[np.float64], within: float
    ) -> NDArray[np.bool_]:
        """Which points of surfaces it shows, from the same side.

        Args:
            points_xyz: (n, 3) [m] map frame.
            normals_xyz: (n, 3) of the surfaces, map frame.
            within: Up to this distance [m] along the line of sight.
        """
        matrix = self.T_map_camera.as_matrix()
        points = (points_xyz - matrix[:3, 3]) @ matrix[:3, :3]
        towards = np.einsum("ij,ij->i", points, normals_xyz @ matrix[:3, :3]) < 0
        return towards & self.space.agrees_with(points, within)

    def looks_through(self, points_xyz: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which points lie where it saw nothing.

        Args:
            points_xyz: (n, 3) [m] map frame.
        """
        matrix = self.T_map_camera.as_matrix()
        return self.space.contains((points_xyz - matrix[:3, 3]) @ matrix[:3, :3])
