"""Reader of the YAML calibrations of ROS, OpenCV and Kalibr."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from circumspect.errors import CircumspectError, InputError
from circumspect.localization.lens_camera import REMEDY, LensCamera, lens_of
from circumspect.sensing.untrusted_files import read_yaml

SUFFIXES = (".yaml", ".yml")
MAX_BYTES = 1 << 20
MATRIX = ("cameramatrix", "k", "intrinsicmatrix", "mtx")
DISTORTION = ("distortioncoefficients", "distcoeffs", "distortion", "d", "dist")
WIDTH, HEIGHT = ("imagewidth", "width"), ("imageheight", "height")
SIZE = ("imagesize", "resolution")
MODEL = ("distortionmodel",)
OPENCV_MATRIX = "tag:yaml.org,2002:opencv-matrix"


def read_camera_yaml(path: Path, camera: str) -> LensCamera:
    """Read the lens of a camera.

    Args:
        path: A file of ROS's camera_calibration, of OpenCV's FileStorage, or of Kalibr.
        camera: Name of the camera; a Kalibr file may contain several.

    Raises:
        InputError: The file cannot be read, has no or an unsupported lens, or several cameras.
        MissingExtraError: PyYAML is not installed.
    """
    document = read_yaml(path, MAX_BYTES, "a camera's calibration", "locate", _loader)
    try:
        if not isinstance(document, dict):
            raise InputError(f"holds no camera; {REMEDY}")
        chain = {name: one for name, one in document.items() if _is_kalibr(one)}
        if chain:
            return _of_kalibr(_chosen(chain, camera))
        return _of_opencv({_key(name): value for name, value in document.items()})
    except CircumspectError as error:
        raise InputError(f"{path}: {error}") from error


def _loader() -> Any:
    """A loader of plain values; OpenCV's matrices become mappings."""
    import yaml

    class Loader(yaml.SafeLoader):
        """PyYAML's safe loader with an additional tag."""

        def opencv_matrix(self, node: Any) -> Any:
            return self.construct_mapping(node, deep=True)

    Loader.add_constructor(OPENCV_MATRIX, Loader.opencv_matrix)
    return Loader


def _is_kalibr(entry: Any) -> bool:
    return isinstance(entry, dict) and "camera_model" in entry and "intrinsics" in entry


def _chosen(chain: Mapping[Any, Any], camera: str) -> Mapping[str, Any]:
    if camera in chain:
        return chain[camera]
    if len(chain) > 1:
        names = ", ".join(map(str, chain))
        raise InputError(f"holds several cameras, {names}, and none is '{camera}'; give --camera")
    return next(iter(chain.values()))


def _of_kalibr(entry: Mapping[str, Any]) -> LensCamera:
    if entry["camera_model"] != "pinhole":
        raise InputError(f"the camera model {entry['camera_model']!r} is not supported; {REMEDY}")
    fx, fy, cx, cy = _numbers(entry["intrinsics"], "intrinsics", 4)
    model = str(entry.get("distortion_model", ""))
    bend = _numbers(entry.get("distortion_coeffs"), "distortion_coeffs")
    size = _numbers(entry.get("resolution"), "resolution", 2)
    return lens_of(size, [fx, 0, cx, 0, fy, cy, 0, 0, 1], bend, model)


def _of_opencv(entry: Mapping[str, Any]) -> LensCamera:
    K = _numbers(_first(entry, MATRIX, "camera_matrix"), "camera_matrix", 9)
    if any(name in entry for name in SIZE):
        size = _numbers(_first(entry, SIZE, "image_size"), "image_size", 2)
    else:
        size = [
            *_numbers(_first(entry, WIDTH, "image_width"), "image_width", 1),
            *_numbers(_first(entry, HEIGHT, "image_height"), "image_height", 1),
        ]
    bend = _first(entry, DISTORTION, "distortion_coefficients")
    model = next((str(entry[name]) for name in MODEL if name in entry), "")
    return lens_of(size, K, _numbers(bend, "distortion_coefficients"), model)


def _key(name: Any) -> str:
    """Normalised name; programs differ in capitals and underscores."""
    return str(name).lower().replace("_", "")


def _first(entry: Mapping[str, Any], names: tuple[str, ...], usual: str) -> Any:
    for name in names:
        if name in entry:
            return entry[name]
    raise InputError(f"has no {usual}; {REMEDY}")


def _numbers(value: Any, name: str, count: int | None = None) -> list[float]:
    """Finite numbers of a list, of lists, of a matrix with its data, or of one number."""
    held = value.get("data") if isinstance(value, dict) else value
    try:
        numbers = np.ravel(np.array(held, np.float64)).tolist()
    except (TypeError, ValueError):
        numbers = []
    if not numbers or not np.isfinite(numbers).all() or len(numbers) != (count or len(numbers)):
        wanted = "finite numbers" if count is None else f"{count} finite numbers"
        raise InputError(f"needs {wanted} in {name}")
    return numbers
