"""Conversion of depth and colour images to and from `sensor_msgs`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera
from circumspect.recording.compressed_depth import MAX_SIDE_PX, compressed_depth, scaled
from circumspect.recording.ros_time import header
from circumspect.recording.ros_types import CAMERA_INFO, IMAGE, message
from circumspect.sensing.millimetres import metres, millimetres
from circumspect.sensing.untrusted_files import opened_picture

DEPTH_16, DEPTH_32 = "16UC1", "32FC1"
DEPTH_TYPES = {DEPTH_16: "u2", "mono16": "u2", DEPTH_32: "f4"}
CHANNELS = {
    "rgb8": [0, 1, 2],
    "bgr8": [2, 1, 0],
    "rgba8": [0, 1, 2],
    "bgra8": [2, 1, 0],
    "mono8": [0, 0, 0],
}
"""Encoding to the channels of red, green and blue."""
BYTES = {"rgb8": 3, "bgr8": 3, "rgba8": 4, "bgra8": 4, "mono8": 1}


def depth_message(depth: NDArray[np.float32], stamp: float, frame_id: str) -> Any:
    """Encode depth as `sensor_msgs/Image`: 16UC1 if that is lossless, else 32FC1.

    Args:
        depth: (height, width) [m], NaN where invalid.
        stamp: Time [s].
        frame_id: Name of the optical frame.
    """
    whole = millimetres(depth)
    if np.array_equal(metres(whole), depth, equal_nan=True):
        return _image(whole, DEPTH_16, stamp, frame_id)
    return _image(depth, DEPTH_32, stamp, frame_id)


def colour_message(colour: NDArray[np.uint8], stamp: float, frame_id: str) -> Any:
    """Encode (height, width, 3) colours as `sensor_msgs/Image` in rgb8."""
    return _image(colour, "rgb8", stamp, frame_id)


def grey_message(grey: NDArray[np.uint8], stamp: float, frame_id: str) -> Any:
    """Encode (height, width) brightness as `sensor_msgs/Image` in mono8."""
    return _image(grey, "mono8", stamp, frame_id)


def _image(pixels: NDArray[Any], encoding: str, stamp: float, frame_id: str) -> Any:
    flat = np.ascontiguousarray(pixels).view(np.uint8).reshape(-1)
    return message(
        IMAGE, header=header(stamp, frame_id), height=pixels.shape[0], width=pixels.shape[1],
        encoding=encoding, is_bigendian=0, step=len(flat) // pixels.shape[0], data=flat,
    )  # fmt: skip


def depth_of(image: Any, scale: float | None = None) -> NDArray[np.float32]:
    """Decode depth from `sensor_msgs/Image` or `CompressedImage`.

    Args:
        image: The message.
        scale: Metres per unit; None for millimetres in integer and metres in float images.

    Returns:
        (height, width) float32 [m], NaN where invalid.

    Raises:
        InputError: Unknown encoding, or data that do not fill the image.
    """
    if hasattr(image, "format"):
        return compressed_depth(image, scale)
    kind = DEPTH_TYPES.get(image.encoding)
    if kind is None:
        raise InputError(
            f"unknown depth encoding {image.encoding[:20]!r}; known: {', '.join(DEPTH_TYPES)}"
        )
    pixels = _rows(image, np.dtype(kind))
    if kind == "f4":
        return pixels.astype(np.float32) * np.float32(1.0 if scale is None else scale)
    return metres(pixels) if scale is None else scaled(pixels, scale)


def colour_of(image: Any) -> NDArray[np.uint8]:
    """Decode (height, width, 3) RGB from `sensor_msgs/Image`.

    Raises:
        InputError: Unknown encoding, or data that do not fill the image.
    """
    if image.encoding not in CHANNELS:
        raise InputError(
            f"unknown colour encoding {image.encoding[:20]!r}; known: {', '.join(CHANNELS)}"
        )
    pixels = _rows(image, np.dtype((np.uint8, (BYTES[image.encoding],))))
    return np.ascontiguousarray(pixels[..., CHANNELS[image.encoding]])


def grey_of(image: Any) -> NDArray[np.uint8]:
    """Decode (height, width) brightness from `sensor_msgs/Image` or `CompressedImage`.

    Raises:
        InputError: Unknown encoding, or data that are not an image.
    """
    from PIL import Image

    if hasattr(image, "format"):
        return _decoded(image)
    colour = colour_of(image)
    if image.encoding == "mono8":
        return np.ascontiguousarray(colour[..., 0])
    return np.array(Image.fromarray(colour).convert("L"))


def _decoded(image: Any) -> NDArray[np.uint8]:
    """(height, width) brightness of an 8-bit JPEG or PNG."""
    packed, name = bytes(image.data), "a compressed image"
    with opened_picture(packed, ("JPEG", "PNG"), MAX_SIDE_PX, name) as picture:
        if picture.mode.startswith(("I", "F")):
            raise InputError(f"an image in mode {picture.mode}")
        return np.array(picture.convert("L"))


def _rows(image: Any, pixel: np.dtype[Any]) -> NDArray[Any]:
    """(height, width, …) pixels without row padding, in native byte order."""
    height, width, step = image.height, image.width, image.step
    held = step >= width * pixel.itemsize and len(image.data) >= step * height
    if not (0 < height <= MAX_SIDE_PX and 0 < width <= MAX_SIDE_PX and held):
        raise InputError(
            f"an image of {width} x {height} pixels with {len(image.data)} bytes in rows of {step}"
        )
    rows = np.asarray(image.data, np.uint8)[: step * height].reshape(height, step)
    packed = np.ascontiguousarray(rows[:, : width * pixel.itemsize])
    if pixel.subdtype is not None:
        return packed.reshape(height, width, -1)
    order = ">" if image.is_bigendian else "<"
    return packed.view(pixel.newbyteorder(order)).astype(pixel, copy=False)


def camera_info(
    camera: PinholeCamera, stamp: float, frame_id: str, distortion: Sequence[float] = (0.0,) * 5
) -> Any:
    """Create a `sensor_msgs/CameraInfo`.

    Args:
        camera: Image size and focal lengths.
        stamp: Time [s].
        frame_id: Name of the optical frame.
        distortion: k1, k2, p1, p2, k3 ("plumb_bob").
    """
    K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    roi = message(
        "sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0,
        do_rectify=False,
    )  # fmt: skip
    return message(
        CAMERA_INFO, header=header(stamp, frame_id), height=camera.height, width=camera.width,
        distortion_model="plumb_bob", d=np.array(distortion, float), k=K.ravel(),
        r=np.eye(3).ravel(), p=np.hstack([K, np.zeros((3, 1))]).ravel(),
        binning_x=0, binning_y=0, roi=roi,
    )  # fmt: skip


def camera_of(info: Any) -> PinholeCamera:
    """Camera of the rectified images, from a `sensor_msgs/CameraInfo` of ROS 2 or ROS 1.

    P describes the rectified image. Some drivers leave it empty; then K of the raw image is used.

    Raises:
        InputError: It has no focal length, or the images are binned.
    """
    P = _matrix_field(info, "p", (3, 4))[:, :3]
    matrix = P if P[0, 0] > 0 else _matrix_field(info, "k", (3, 3))
    (fx, _, cx), (_, fy, cy), _ = matrix.tolist()
    if not matrix.any():
        raise InputError("the CameraInfo is all zero: the driver has no calibration of the camera")
    if not np.isfinite(matrix).all() or not (fx > 0 and fy > 0):
        raise InputError("the CameraInfo has no focal length: is the camera calibrated?")
    if max(info.binning_x, info.binning_y) > 1:
        raise InputError("binned images (see the CameraInfo) are not supported")
    return PinholeCamera(info.width, info.height, fx, fy, cx, cy)


def _matrix_field(info: Any, name: str, shape: tuple[int, int]) -> NDArray[np.float64]:
    """A matrix of a CameraInfo (upper-case names in ROS 1); zeros if it is missing."""
    values = np.asarray(getattr(info, name if hasattr(info, name) else name.upper()), np.float64)
    return values.reshape(shape) if values.size == shape[0] * shape[1] else np.zeros(shape)


def is_distorted(info: Any) -> bool:
    """Whether a `sensor_msgs/CameraInfo` has distortion coefficients."""
    return bool(np.any(np.asarray(info.d if hasattr(info, "d") else info.D, np.float64) != 0))
