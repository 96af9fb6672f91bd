"""File with the calibration of all cameras of a room."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import CircumspectError, InputError
from circumspect.geometry import PlanarPose
from circumspect.localization.camera_yaml import SUFFIXES, read_camera_yaml
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.json_file import number, numbers, read_document, section, text
from circumspect.localization.lens_camera import (
    COEFFICIENT_COUNTS,
    INTEGER_TOLERANCE,
    LensCamera,
    lens_of,
)
from circumspect.localization.survey import require_plausible_position
from circumspect.localization.tag_detector import FAMILY
from circumspect.localization.tag_mount import TagMount
from circumspect.storage import write_json

UNIT_TOLERANCE = 1e-3
UNSUPPORTED_SUFFIXES = (".npz", ".npy", ".xml", ".pkl", ".pickle", ".mat", ".txt", ".ini")
"""Suffixes of unsupported calibration files of other programs."""
MODEL_NAMES = ("model", "distortion_model")
"""Names of the entry with the lens model in files of other programs."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """Lenses and poses of the cameras, and the tag on the robot.

    Attributes:
        lenses: Intrinsics by camera.
        lens_rms_px: Reprojection error of their calibration [px], by camera.
        cameras: Cameras with a known pose.
        mount: The robot's tag; None if unknown.
    """

    lenses: Mapping[str, LensCamera]
    lens_rms_px: Mapping[str, float]
    cameras: tuple[FixedCamera, ...] = ()
    mount: TagMount | None = None

    @classmethod
    def of(cls, cameras: Sequence[FixedCamera], mount: TagMount | None = None) -> Calibration:
        """Create from cameras with known lens and pose."""
        lenses = {camera.name: camera.lens for camera in cameras}
        return cls(lenses, dict.fromkeys(lenses, 0.0), tuple(cameras), mount)

    def with_lens(self, name: str, lens: LensCamera, rms_px: float) -> Calibration:
        """Replace the lens of a camera, which invalidates its pose."""
        return Calibration(
            {**self.lenses, name: lens},
            {**self.lens_rms_px, name: rms_px},
            tuple(camera for camera in self.cameras if camera.name != name),
            self.mount,
        )

    def with_place(self, camera: FixedCamera) -> Calibration:
        """Replace the pose of a camera."""
        others = [other for other in self.cameras if other.name != camera.name]
        placed = tuple(sorted([*others, camera], key=lambda c: c.name))
        lenses = {**self.lenses, camera.name: camera.lens}
        rms = {camera.name: 0.0, **self.lens_rms_px}
        return Calibration(lenses, rms, placed, self.mount)

    def merged_with(self, other: Calibration) -> Calibration:
        """Add further cameras of another calibration, and its tag if this one has none."""
        further = [camera for camera in other.cameras if camera.name not in self.lenses]
        return Calibration(
            {**other.lenses, **self.lenses},
            {**other.lens_rms_px, **self.lens_rms_px},
            tuple(sorted([*self.cameras, *further], key=lambda c: c.name)),
            self.mount or other.mount,
        )

    def mount_with(self, tag: tuple[int, float, float] | None) -> TagMount | None:
        """The robot's tag at its known position on the robot.

        Args:
            tag: Its number, size [m] and height [m]; None for the known ones.
        """
        if tag is None:
            return self.mount
        number, size, height = tag
        return replace(self.mount or TagMount(), tag_id=number, size=size, height=height)

    def lens(self, name: str) -> LensCamera:
        """A camera's lens.

        Raises:
            InputError: The camera is not calibrated.
        """
        if name not in self.lenses:
            raise InputError(
                f"no intrinsics of camera '{name}'; known: {', '.join(self.lenses) or 'none'}; "
                "find them with: circumspect locate intrinsics"
            )
        return self.lenses[name]

    @property
    def without_pose(self) -> tuple[str, ...]:
        """Cameras without a known pose."""
        placed = {camera.name for camera in self.cameras}
        return tuple(name for name in self.lenses if name not in placed)


def write_calibration(path: str | os.PathLike[str], calibration: Calibration) -> None:
    """Write a calibration as JSON.

    Raises:
        OutputError: The file cannot be written.
    """
    placed = {camera.name: camera for camera in calibration.cameras}
    cameras: dict[str, Any] = {}
    for name, lens in calibration.lenses.items():
        pinhole = lens.pinhole
        entry: dict[str, Any] = {
            "width": pinhole.width,
            "height": pinhole.height,
            "K": [[pinhole.fx, 0.0, pinhole.cx], [0.0, pinhole.fy, pinhole.cy], [0.0, 0.0, 1.0]],
            "distortion": list(lens.distortion),
            "rms_px": calibration.lens_rms_px.get(name, 0.0),
        }
        if (camera := placed.get(name)) is not None:
            pose = camera.T_map_camera
            entry["extrinsics"] = {
                "translation": pose.translation,
                "quaternion_xyzw": pose.rotation.as_quat(canonical=True),
                "covariance": camera.covariance,
                "rms_px": camera.rms_px,
            }
        cameras[name] = entry
    document: dict[str, Any] = {"tag_family": FAMILY}
    if (mount := calibration.mount) is not None:
        tag = mount.T_base_tag
        document["tag"] = {
            "id": mount.tag_id,
            "size_m": mount.size,
            "height_m": mount.height,
            "x": tag.x,
            "y": tag.y,
            "yaw_deg": float(np.degrees(tag.yaw)),
        }
    write_json(path, {**document, "cameras": cameras})


def read_calibration(path: str | os.PathLike[str]) -> Calibration:
    """Read a file of `write_calibration`.

    Raises:
        InputError: The file is missing or broken; the message names the camera and the entry.
    """
    if not Path(path).exists():
        raise InputError(
            f"{path}: does not exist; calibrate with: circumspect locate intrinsics, and then "
            "circumspect locate extrinsics"
        )
    if Path(path).suffix.lower() in SUFFIXES:
        raise InputError(
            f"{path}: YAML files contain a lens, but no pose; find it with: circumspect locate "
            f"extrinsics IMAGES --survey SURVEY --intrinsics {path} --out calibration.json"
        )
    with read_document(path) as document:
        family = document.get("tag_family", FAMILY)
        if family != FAMILY:
            raise InputError(f"unknown tag family {family}; use {FAMILY}")
        lenses: dict[str, LensCamera] = {}
        rms: dict[str, float] = {}
        cameras: list[FixedCamera] = []
        entries = section(document, "cameras")
        for name in entries:
            try:
                entry = section(entries, name)
                lenses[name] = _lens(entry)
                rms[name] = number(entry, "rms_px", 0.0)
                if "extrinsics" in entry:
                    cameras.append(_placed(name, lenses[name], section(entry, "extrinsics")))
            except CircumspectError as error:
                raise InputError(f"camera '{name}': {error}") from error
        return Calibration(lenses, rms, tuple(cameras), _mount(document))


def read_lenses(path: str | os.PathLike[str], camera: str) -> Calibration:
    """Read the lens of a camera from a file of this or another program.

    Args:
        path: A file of `write_calibration`, or YAML of ROS, OpenCV or Kalibr.
        camera: Its name.

    Raises:
        InputError: The file is missing or broken, or holds no such lens.
        MissingExtraError: It is YAML, and PyYAML is not installed.
    """
    place = Path(path)
    if place.suffix.lower() in SUFFIXES:
        return Calibration({camera: read_camera_yaml(place, camera)}, {camera: 0.0})
    if place.suffix.lower() in UNSUPPORTED_SUFFIXES:
        raise InputError(
            f"{path}: unsupported; supported are JSON of `circumspect locate intrinsics`, and "
            "YAML of ROS, OpenCV or Kalibr"
        )
    return read_calibration(path)


def _lens(entry: Mapping[str, Any]) -> LensCamera:
    K = entry.get("K")
    flat = isinstance(K, list) and len(K) == 9
    rows = numbers(entry, "K", 9) if flat else [v for row in _matrix(entry, "K", 3) for v in row]
    bend = entry.get("distortion")
    if isinstance(bend, list) and len(bend) == 1 and isinstance(bend[0], list):
        bend = bend[0]  # OpenCV's arrays have two dimensions.
    count = (
        len(bend)
        if isinstance(bend, list) and len(bend) in COEFFICIENT_COUNTS
        else COEFFICIENT_COUNTS[1]
    )
    found = numbers({**entry, "distortion": bend}, "distortion", count)
    size = number(entry, "width"), number(entry, "height")
    named = [name for name in MODEL_NAMES if name in entry]
    return lens_of(size, rows, found, text(entry, named[0]) if named else "")


def _placed(name: str, lens: LensCamera, entry: Mapping[str, Any]) -> FixedCamera:
    quaternion = np.array(numbers(entry, "quaternion_xyzw", 4))
    if abs(np.linalg.norm(quaternion) - 1) > UNIT_TOLERANCE:
        raise InputError(f"the quaternion (x, y, z, w) is not of unit length: {quaternion}")
    place = numbers(entry, "translation", 3)
    require_plausible_position("it", place)
    pose = RigidTransform.from_components(place, Rotation.from_quat(quaternion))
    covariance = np.zeros((6, 6))
    if "covariance" in entry:
        covariance = np.array(_matrix(entry, "covariance", 6))
    return FixedCamera(name, lens, pose, covariance, number(entry, "rms_px", 0.0))


def _matrix(entry: Mapping[str, Any], name: str, size: int) -> list[list[float]]:
    found = entry.get(name)
    if not isinstance(found, list) or len(found) != size:
        raise InputError(f"needs a matrix '{name}' of {size} x {size} numbers")
    return [numbers({name: row}, name, size) for row in found]


def _mount(document: Mapping[str, Any]) -> TagMount | None:
    if "tag" not in document:
        return None
    tag = section(document, "tag")
    tag_id = number(tag, "id")
    if abs(tag_id - round(tag_id)) > INTEGER_TOLERANCE:
        raise InputError(f"the tag's id must be an integer, not {tag_id}")
    text({"tag_family": FAMILY, **document}, "tag_family")
    yaw = float(np.radians(number(tag, "yaw_deg", 0.0)))
    place = PlanarPose(number(tag, "x", 0.0), number(tag, "y", 0.0), yaw)
    return TagMount(round(tag_id), number(tag, "size_m"), number(tag, "height_m"), place)
