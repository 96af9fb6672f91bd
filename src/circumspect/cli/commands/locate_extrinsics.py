"""`circumspect locate extrinsics`."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.commands.locate_intrinsics import folder_camera
from circumspect.cli.config_file import ConfigFlag
from circumspect.errors import InputError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from circumspect.localization import LensCamera


@dataclass(frozen=True)
class Extrinsics:
    r"""Calibrate the pose of one camera from tags at surveyed places on the floor.

    $ circumspect locate extrinsics floor/ceiling_0 \
          --survey survey.json --intrinsics calibration.json \
          --out calibration.json
    """

    images: Annotated[tuple[Path, ...], tyro.conf.Positional, tyro.conf.arg(metavar="IMAGES")]
    """Images of the floor, or a folder of images, all from the mounted camera."""
    survey: Path
    """Poses of the tags: {"tag_size_m": 0.16, "tags": {"100": {"x": 0, "y": 1, "yaw_deg": 90}}}"""
    intrinsics: Path
    """Calibration file with the camera's intrinsics, or a YAML file of ROS, OpenCV or Kalibr."""
    out: Path
    """Calibration file to write, the same or another; its entries of other cameras are kept."""
    camera: str | None = None
    """Name of the camera; by default that of the folder of the images."""
    tag: tuple[int, float, float] | None = None
    """The robot's tag, stored for `track`: number, size [m], height above the floor [m]. Its
    position on the robot in the file is kept."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Detect tags, fit the pose and write the calibration."""
        import numpy as np

        from circumspect.localization import (
            TagDetector,
            calibrate_extrinsics,
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
        found = calibrate_extrinsics(name, lens, images, survey)
        after = kept.merged_with(known).with_lens(name, lens, known.lens_rms_px.get(name, 0.0))
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
            "missing": list(after.without_pose),
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
        if after.without_pose:
            print(f"Still without a place: {', '.join(after.without_pose)}")  # noqa: T201
        return 0


def _of_size(grey: NDArray[np.uint8], lens: LensCamera, file: Path) -> NDArray[np.uint8]:
    """The image, if it has the size for which the lens was calibrated."""
    (height, width), (w, h) = grey.shape, lens.size
    if (width, height) != (w, h):
        raise InputError(f"{file}: has {width}x{height} pixels, the lens was calibrated at {w}x{h}")
    return grey
