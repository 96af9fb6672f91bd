"""`circumspect locate extrinsics`."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.camera_name import folder_camera
from circumspect.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from circumspect.localization import LensCamera


@dataclass(frozen=True)
class Extrinsics:
    r"""Find one camera's place from tags that lie at surveyed places on the floor.

    $ circumspect locate extrinsics floor/ceiling_0 \
          --survey survey.json --intrinsics calibration.json \
          --out calibration.json
    """

    images: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="IMAGES")]
    """Images of the floor, or a folder of them; all from where the camera hangs."""
    survey: Path
    """Where the tags lie: {"tag_size_m": 0.16, "tags": {"100": {"x": 0, "y": 1, "yaw_deg": 90}}}"""
    intrinsics: Path
    """Calibration file that holds the camera's lens, or a YAML file of ROS, OpenCV or Kalibr."""
    out: Path
    """Calibration file to write, the same or another; what it holds of other cameras stays."""
    camera: str | None = None
    """Name of the camera; that of the images' folder by default."""
    tag: tuple[int, float, float] | None = None
    """The robot's tag, written down for `track`: number, size [m], height above the floor [m]; its
    place on the robot stays what the file says."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

    def run(self) -> int:
        """Find tags, fit the place, write it down."""
        import numpy as np

        from circumspect.localization import (
            TagDetector,
            calibrate_place,
            read_calibration,
            read_lenses,
            read_survey,
            write_calibration,
        )
        from circumspect.localization.image_folder import image_files, read_grey

        survey, files = read_survey(self.survey), image_files(list(self.images))
        name = self.camera or folder_camera(files)
        known = read_lenses(self.intrinsics, name)
        kept = read_calibration(self.out) if self.out.exists() else known
        lens, detector = known.lens(name), TagDetector(1.0)
        images = [detector.detect(_of_size(read_grey(file), lens, file)) for file in files]
        found = calibrate_place(name, lens, images, survey)
        after = kept.beside(known).with_lens(name, lens, known.lens_rms_px.get(name, 0.0))
        after = replace(after.with_place(found.camera), mount=after.mount_with(self.tag))
        write_calibration(self.out, after)
        camera = found.camera
        record: dict[str, Any] = {
            "camera": name,
            "rms_px": camera.rms_px,
            "position_xyz": camera.position_xyz.tolist(),
            "sigma_m": np.sqrt(np.diag(camera.covariance)[3:]).tolist(),
            "tags": len(found.offsets_m),
            "largest_offset_m": max(found.offsets_m.values()),
            "left_out": {str(tag): reason for tag, reason in found.left_out.items()},
            "calibration": str(self.out),
            "missing": list(after.unplaced),
        }
        if self.json:
            print(json.dumps(record))  # noqa: T201
            return 0
        for tag, reason in record["left_out"].items():
            print(f"left out: tag {tag}: {reason}")  # noqa: T201
        x, y, z = record["position_xyz"]
        print(  # noqa: T201
            f"Camera '{name}' hangs at {x:.3f}, {y:.3f}, {z:.3f} m: {camera.rms_px:.3f} px over "
            f"{record['tags']} tags."
        )
        if after.unplaced:
            print(f"Still without a place: {', '.join(after.unplaced)}")  # noqa: T201
        return 0


def _of_size(grey: NDArray[np.uint8], lens: LensCamera, file: Path) -> NDArray[np.uint8]:
    """The image, if the lens was calibrated for such."""
    (height, width), (w, h) = grey.shape, lens.size
    if (width, height) != (w, h):
        raise InputError(f"{file}: has {width}x{height} pixels, the lens was calibrated at {w}x{h}")
    return grey
