"""Files as the RealSense SDK records them, from its software device."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from circumspect.geometry import PinholeCamera

UNIT = 0.00025
"""Metres a unit; cameras of today can be set to it."""


def recorded(
    path: Path,
    sdk: Any,
    depths: Sequence[np.ndarray],
    camera: PinholeCamera,
    name: str = "Intel RealSense D455",
    interval: float = 0.1,
) -> Path:
    """Record depth images [m], as a camera's stream."""
    device = sdk.software_device()
    device.register_info(sdk.camera_info.name, name)
    sensor = device.add_sensor("Stereo Module")
    stated = sdk.intrinsics()
    stated.width, stated.height = camera.width, camera.height
    stated.fx, stated.fy, stated.ppx, stated.ppy = camera.fx, camera.fy, camera.cx, camera.cy
    stated.model, stated.coeffs = sdk.distortion.none, [0.0] * 5
    stream = sdk.video_stream()
    stream.type, stream.index, stream.uid = sdk.stream.depth, 0, 1
    stream.width, stream.height, stream.fps, stream.bpp = camera.width, camera.height, 30, 2
    stream.fmt, stream.intrinsics = sdk.format.z16, stated
    profile = sensor.add_video_stream(stream)
    sensor.add_read_only_option(sdk.option.depth_units, UNIT)
    recorder = sdk.recorder(str(path), device)
    (recording,) = recorder.query_sensors()
    recording.open(profile)
    queue = sdk.frame_queue(len(depths) + 1)
    recording.start(queue)
    for number, depth in enumerate(depths):
        frame = sdk.software_video_frame()
        units = np.nan_to_num(depth / UNIT)
        frame.pixels = np.where(units < 65535, units, 0).round().astype(np.uint16)
        frame.stride, frame.bpp, frame.depth_units = 2 * camera.width, 2, UNIT
        frame.timestamp, frame.frame_number = 1e3 * (5 + interval * number), number
        frame.domain, frame.profile = (
            sdk.timestamp_domain.hardware_clock,
            profile.as_video_stream_profile(),
        )
        sensor.on_video_frame(frame)
        time.sleep(0.01)
    time.sleep(0.2)
    recording.stop()
    recording.close()
    return path
