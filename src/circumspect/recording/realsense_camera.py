"""RealSense cameras without ROS, and recordings of their SDK."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from circumspect.errors import InputError, MissingExtraError
from circumspect.geometry import PinholeCamera
from circumspect.recording.compressed_depth import scaled
from circumspect.sensing import RgbdCamera, RgbdFrame

DEPTH_RANGES = {
    "D405": (0.07, 0.5),
    "D415": (0.5, 3.0),
    "D435": (0.3, 3.0),
    "D455": (0.6, 6.0),
    "D456": (0.6, 6.0),
    "D457": (0.6, 6.0),
    "L515": (0.25, 9.0),
}
"""Model to its ideal range according to the data sheet [m]."""
DEFAULT_RANGE = DEPTH_RANGES["D435"]
LIVE_TIMEOUT_S, FILE_TIMEOUT_S = 5.0, 2.0
"""Maximum time to wait for a frame [s]."""
POLL_S = 0.2
"""Interval of the checks for the end of a file [s]."""


class RealSenseCamera(RgbdCamera):
    """A connected camera, or a recording of the SDK, played without dropping frames.

    Colour is aligned to the depth. The class is a context manager that stops the streams.

    Attributes:
        name: Device name, such as "Intel RealSense D435".
    """

    def __init__(self, file: str | os.PathLike[str] | None = None) -> None:
        """Start the streams.

        Args:
            file: A recording of the SDK; None for the first connected camera.

        Raises:
            InputError: No camera is connected, or the file cannot be played.
            MissingExtraError: pyrealsense2 is not installed.
        """
        self._sdk = realsense_sdk()
        self._file = None if file is None else Path(file)
        if self._file is not None and not self._file.is_file():
            raise InputError(f"{file}: no such file")
        context = self._sdk.context()
        if self._file is None and not len(context.query_devices()):
            raise InputError(
                "no RealSense camera is connected; check cable, USB port and udev rules"
            )
        self._pipeline = self._sdk.pipeline(context)
        try:
            profile = self._started()
            device = profile.get_device()
            self._playback = None
            if self._file is not None:
                self._playback = device.as_playback()
                self._playback.set_real_time(False)
            sensor = device.first_depth_sensor()
            depth = profile.get_stream(self._sdk.stream.depth).as_video_stream_profile()
        except RuntimeError as error:
            raise InputError(self._open_error(error)) from error
        self._scale = float(sensor.get_depth_scale())
        self.name = self._device_name(device)
        self._range = self._device_range(sensor)
        self._intrinsics = _pinhole(depth.get_intrinsics())
        kinds = {stream.stream_type() for stream in profile.get_streams()}
        has_colour = self._sdk.stream.color in kinds
        self._align = self._sdk.align(self._sdk.stream.depth) if has_colour else None
        self._stamp = -np.inf

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __iter__(self) -> Iterator[RgbdFrame]:
        """The frames, without end or up to the end of the file.

        Raises:
            InputError: A connected camera stopped sending frames.
        """
        while (frame := self._next()) is not None:
            yield frame

    @property
    def intrinsics(self) -> PinholeCamera:
        """See `RgbdCamera.intrinsics`."""
        return self._intrinsics

    @property
    def depth_range(self) -> tuple[float, float]:
        """See `RgbdCamera.depth_range`: from the device, or else from its model."""
        return self._range

    def capture(self) -> RgbdFrame:
        """See `RgbdCamera.capture`.

        Raises:
            InputError: No frame arrives.
        """
        frame = self._next()
        if frame is None:
            raise InputError(f"{self._file}: contains no more frames")
        return frame

    def close(self) -> None:
        """Stop the streams."""
        with suppress(RuntimeError):  # They have already stopped.
            self._pipeline.stop()

    def _started(self) -> Any:
        config = self._sdk.config()
        if self._file is not None:
            config.enable_device_from_file(str(self._file), repeat_playback=False)
            return self._pipeline.start(config)
        config.enable_stream(self._sdk.stream.depth)
        config.enable_stream(self._sdk.stream.color, self._sdk.format.rgb8)
        try:
            return self._pipeline.start(config)
        except RuntimeError:
            # Not every model has a colour camera.
            plain = self._sdk.config()
            plain.enable_stream(self._sdk.stream.depth)
            return self._pipeline.start(plain)

    def _open_error(self, error: RuntimeError) -> str:
        reason = (str(error).splitlines() or ["no reason"])[0].rstrip(".")
        if self._file is not None:
            return (
                f"{self._file}: the RealSense SDK can not play it ({reason}); play a ROS bag "
                f"with: circumspect replay {self._file}"
            )
        return f"no RealSense camera can be opened ({reason}); check cable, USB port and udev rules"

    def _device_name(self, device: Any) -> str:
        info = self._sdk.camera_info.name
        return str(device.get_info(info)) if device.supports(info) else "RealSense"

    def _device_range(self, sensor: Any) -> tuple[float, float]:
        option = self._sdk.option
        if sensor.supports(option.min_distance) and sensor.supports(option.max_distance):
            nearest = float(sensor.get_option(option.min_distance))
            farthest = float(sensor.get_option(option.max_distance))
            if 0 < nearest < farthest:
                return nearest, farthest
        return next((r for model, r in DEPTH_RANGES.items() if model in self.name), DEFAULT_RANGE)

    def _next(self) -> RgbdFrame | None:
        """The next frame with a later stamp than all before; None at the end of a file."""
        waited = 0.0
        while True:
            came, frames = self._pipeline.try_wait_for_frames(round(1e3 * POLL_S))
            if not came:
                waited += POLL_S
                if self._has_ended(waited):
                    return None
                continue
            depth = frames.get_depth_frame()
            if not depth or depth.get_timestamp() / 1e3 <= self._stamp:
                continue
            self._stamp = depth.get_timestamp() / 1e3
            units = np.asanyarray(depth.get_data())
            metres = scaled(units, self._scale)
            return RgbdFrame(metres, self._intrinsics, self._stamp, colour=self._colour(frames))

    def _has_ended(self, waited: float) -> bool:
        """Whether the file has ended, after a time without frames [s]."""
        if self._playback is not None:
            stopped = self._playback.current_status() == self._sdk.playback_status.stopped
            return stopped or waited >= FILE_TIMEOUT_S
        if waited >= LIVE_TIMEOUT_S:
            raise InputError(f"{self.name} sent no frame for {LIVE_TIMEOUT_S:g} s")
        return False

    def _colour(self, frames: Any) -> NDArray[np.uint8] | None:
        """(height, width, 3) colours aligned to the depth image, if the camera has them."""
        if self._align is None:
            return None
        colour = self._align.process(frames).get_color_frame()
        if not colour or colour.get_profile().format() != self._sdk.format.rgb8:
            return None
        pixels = np.asanyarray(colour.get_data())
        size = (self._intrinsics.height, self._intrinsics.width, 3)
        return pixels.copy() if pixels.shape == size else None


def realsense_sdk() -> Any:
    """Import `pyrealsense2`.

    Raises:
        MissingExtraError: It or its USB library is not installed.
    """
    with suppress(ImportError):
        return import_module("pyrealsense2")
    try:
        # The wheel depends on the system's libusb, which may be missing.
        library = import_module("libusb_package").get_library_path()
        ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
        return import_module("pyrealsense2")
    except (ImportError, OSError) as error:
        raise MissingExtraError("pyrealsense2", "realsense") from error


def _pinhole(intrinsics: Any) -> PinholeCamera:
    return PinholeCamera(
        intrinsics.width,
        intrinsics.height,
        intrinsics.fx,
        intrinsics.fy,
        intrinsics.ppx,
        intrinsics.ppy,
    )
