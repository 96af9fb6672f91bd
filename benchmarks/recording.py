"""Cost of recording: size and time of a frame, by compression of the depth image.

    python -m benchmarks.recording

Frames of a simulated robot (640 x 480, the Xtion's noise) are compressed in several lossless ways.
Then one run is recorded and read as a whole.
"""

from __future__ import annotations

import argparse
import io
import sys
import tempfile
import time
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import zstandard
from numpy.typing import NDArray
from PIL import Image

from benchmarks.report import RESULTS, write_page
from benchmarks.scan_job import ScanJob, prepared
from circumspect.evaluation.markdown import table
from circumspect.exploration.object_scan import ObjectScan
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.recording import RunRecorder, open_recording
from circumspect.sensing import RgbdFrame
from circumspect.sensing.millimetres import millimetres

FRAMES = 40


def png(pixels: NDArray[np.uint16]) -> bytes:
    """PNG, as in `compressed_depth_image_transport`."""
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG", compress_level=1)
    return stream.getvalue()


PACKERS: dict[str, Callable[[NDArray[np.uint16]], bytes]] = {
    "as it is": lambda pixels: pixels.tobytes(),
    "zstd, level 1": lambda pixels: zstandard.compress(pixels.tobytes(), 1),
    "zstd, level 3 (ours)": lambda pixels: zstandard.compress(pixels.tobytes()),
    "zstd, level 9": lambda pixels: zstandard.compress(pixels.tobytes(), 9),
    "zlib, level 1": lambda pixels: zlib.compress(pixels.tobytes(), 1),
    "PNG, level 1": png,
}


def simulated_frames(count: int) -> list[RgbdFrame]:
    """Frames of a robot that drives round a chair."""
    parts = prepared(ScanJob("recording", "chair-100000", 0.0, 0, frame_interval=2.0, frames=count))
    found: list[RgbdFrame] = []
    parts.scan.run((FrameKeeper(parts.scan, found),))
    return found


class FrameKeeper:
    """Keeps the frames of a scan; a `PipelineObserver`."""

    def __init__(self, scan: ObjectScan, kept: list[RgbdFrame]) -> None:
        self._scan, self._kept = scan, kept

    def on_step(self, step: RecognitionStep) -> None:  # noqa: ARG002
        """Keep the latest frame."""
        if self._scan.frame is not None:
            self._kept.append(self._scan.frame)

    def on_end(self, result: RecognitionResult) -> None:
        """Do nothing."""


def packing(frames: list[RgbdFrame]) -> list[list[str]]:
    """Size and time of each compression."""
    pictures = [millimetres(frame.depth) for frame in frames]
    rows = []
    for name, pack in PACKERS.items():
        sizes, times = [], []
        for picture in pictures:
            start = time.perf_counter()
            sizes.append(len(pack(picture)))
            times.append(1e3 * (time.perf_counter() - start))
        rows.append([name, f"{np.median(sizes) / 1e3:.0f}", f"{np.median(times):.1f}"])
    return rows


def whole(frames: list[RgbdFrame]) -> list[list[str]]:
    """Size of a whole recording, and time to write and to read it, per frame."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        recorder = RunRecorder(path, {})
        writing = []
        for frame in frames:
            start = time.perf_counter()
            recorder.frame(frame)
            writing.append(1e3 * (time.perf_counter() - start))
        recorder.close()
        start = time.perf_counter()
        count = sum(1 for _ in open_recording(path))
        reading = 1e3 * (time.perf_counter() - start) / count
        size = path.stat().st_size / count / 1e3
    return [[f"{size:.0f}", f"{np.median(writing):.1f}", f"{reading:.1f}"]]


def main() -> int:
    """Measure and write `recording.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=FRAMES)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    frames = simulated_frames(arguments.frames)
    packed, run = packing(frames), whole(frames)
    heads = (
        ["depth of a frame", "kB, median", "ms, median"],
        ["kB a frame", "ms to record", "ms to read"],
    )
    text = (
        f"{len(frames)} frames of 640 x 480 with the Xtion's noise, one thread.\n\n"
        f"{table(heads[0], packed)}\n\n"
        "A whole recording: depth, camera info, odometry, transforms.\n\n"
        f"{table(heads[1], run)}"
    )
    write_page(
        "recording", "What recording costs", "python -m benchmarks.recording", text,
        {"packing": packed, "recording": run}, arguments.out,
    )  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
