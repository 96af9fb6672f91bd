"""RealSense cameras without ROS, and the files that their SDK records."""

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
"""Model to its ideal range by the maker's data sheets [m]."""
OTHER_RANGE = DEPTH_RANGES["D435"]
LIVE_TIMEOUT_S, FILE_TIMEOUT_S = 5.0, 2.0
"""So long a frame is waited for."""
POLL_S = 0.2
"""So often it is checked whether a file is at its end."""


class RealSenseCamera(RgbdCamera):
    """A connected camera, or a file that the SDK recorded, played without leaving frames out.

    Colour is aligned to the depth. A context manager: streams end with it.

    Attributes:
        name: Of the device, such as "Intel RealSense D435".
    """

    def __init__(self, file: str | os.PathLike[str] | None = None) -> None:
        """Begin to stream.

        Args:
            file: A recording of the SDK; None means the first camera that is connected.

        Raises:
            InputError: No camera is connected, or the file can not be played.
            MissingExtraError: pyrealsense2 is not installed.
        """
        self._sdk = realsense_sdk()
        self._file = None if file is None else Path(file)
        if self._file is not None and not self._file.is_file():
            raise InputError(f"{file}: no such file")
        context = self._sdk.context()
        if self._file is None and not len(context.query_devices()):
            raise InputError("no RealSense camera is connected; see cable, USB port and udev rules")
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
            raise InputError(self._refusal(error)) from error
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
        """The frames, without end or up to that of the file.

        Raises:
            InputError: A connected camera sends none any more.
        """
        while (frame := self._next()) is not None:
            yield frame

    @property
    def intrinsics(self) -> PinholeCamera:
        """See `RgbdCamera.intrinsics`."""
        return self._intrinsics

    @property
    def depth_range(self) -> tuple[float, float]:
        """See `RgbdCamera.depth_range`: as the device says, or else by its model."""
        return self._range

    def capture(self) -> RgbdFrame:
        """See `RgbdCamera.capture`.

        Raises:
            InputError: No frame comes any more.
        """
        frame = self._next()
        if frame is None:
            raise InputError(f"{self._file}: holds no more frames")
        return frame

    def close(self) -> None:
        """End the streams."""
        with suppress(RuntimeError):  # They have ended.
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

    def _refusal(self, error: RuntimeError) -> str:
        said = (str(error).splitlines() or ["no reason"])[0].rstrip(".")
        if self._file is not None:
            return (
                f"{self._file}: the RealSense SDK can not play it ({said}); a bag of ROS is read "
                f"by: circumspect replay {self._file}"
            )
        return f"no RealSense camera can be opened ({said}); see cable, USB port and udev rules"

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
        return next((r for model, r in DEPTH_RANGES.items() if model in self.name), OTHER_RANGE)

    def _next(self) -> RgbdFrame | None:
        """The next frame whose stamp is later than all before; None at the end of a file."""
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
        """Whether no more frames come, after none came for a time [s]."""
        if self._playback is not None:
            stopped = self._playback.current_status() == self._sdk.playback_status.stopped
            return stopped or waited >= FILE_TIMEOUT_S
        if waited >= LIVE_TIMEOUT_S:
            raise InputError(f"{self.name} sent no frame for {LIVE_TIMEOUT_S:g} s")
        return False

    def _colour(self, frames: Any) -> NDArray[np.uint8] | None:
        """(height, width, 3) on the depth image, where the camera sees colours."""
        if self._align is None:
            return None
        colour = self._align.process(frames).get_color_frame()
        if not colour or colour.get_profile().format() != self._sdk.format.rgb8:
            return None
        pixels = np.asanyarray(colour.get_data())
        size = (self._intrinsics.height, self._intrinsics.width, 3)
        return pixels.copy() if pixels.shape == size else None


def realsense_sdk() -> Any:
    """The module `pyrealsense2`.

    Raises:
        MissingExtraError: It is not installed, or its library of USB is missing.
    """
    with suppress(ImportError):
        return import_module("pyrealsense2")
    try:
        # Its wheel leaves libusb to the system, which may have none.
        library = import_module("libusb_package").get_library_path()
        ctypes.CDLL(str(library), ctypes.RTLD_GLOBAL)
        return import_module("pyrealsense2")
    except (ImportError, OSError) as error:
        raise MissingExtraError("pyrealsense2", "realsense") from error


def _pinhole(stated: Any) -> PinholeCamera:
    return PinholeCamera(stated.width, stated.height, stated.fx, stated.fy, stated.ppx, stated.ppy)
