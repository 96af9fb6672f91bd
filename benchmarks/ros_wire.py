"""Depth images over ROS 2: losses, delays and processor load.

    python -m benchmarks.ros_wire

RustDDS, in the tests' peer, publishes 640 x 480 depth images at 30 Hz on this machine, best effort
and reliable; it shares no code with the node's DDS. The first runs only receive the images, the
others also classify at 5 frames per second. Needs cargo.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.report import RESULTS, write_page
from circumspect.classification import Classifier
from circumspect.evaluation.markdown import table
from circumspect.furniture import make_furniture
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.recording.ros_types import IMAGE
from circumspect.ros.dds_middleware import DdsMiddleware
from circumspect.ros.dds_settings import DdsSettings
from circumspect.ros.middleware import SENSOR
from circumspect.ros.node_settings import NodeSettings
from circumspect.ros.recognition_node import RecognitionNode
from circumspect.ros.wire_messages import deserialized
from circumspect.sensing import DepthNoise
from circumspect.sensing.millimetres import millimetres
from circumspect.simulation import CameraMount, Orbit, Scene, SimulatedCamera

ROOT = Path(__file__).resolve().parent.parent
PEER, TARGET = ROOT / "tests" / "ros" / "peer", ROOT / "build" / "ros2-peer-optimised"
OPTIMISED = "profile.dev.opt-level=1"
"""The tests build the peer without optimisation; here it must not limit the rate."""
DEPTH = "/camera/depth/image_rect_raw"
DOMAIN, RATE, STATIONS = 77, 30.0, 20
RELIABILITIES = (("best-effort", False), ("reliable", False), ("reliable", True))
"""Reliability of the publisher, and whether the node requests lost samples."""
HEADS = [
    "publisher",
    "node asks",
    "the node",
    "sent",
    "received",
    "lost",
    "dropped",
    "gap [ms]",
    "cores",
]
"""Columns of the table; the text of the page explains them."""


def built() -> Path:
    """The peer's program."""
    cargo = shutil.which("cargo")
    if cargo is None:
        raise SystemExit("needs cargo; see rustup.rs")
    words = [cargo, "build", "--locked", "--quiet", "--config", OPTIMISED]
    words += ["--target-dir", str(TARGET)]
    subprocess.run(words, cwd=PEER, check=True)
    return TARGET / "debug" / "ros2-peer"


def scene(path: Path) -> Path:
    """The file that the peer publishes: frames of an orbit of a chair; see the peer's scene.rs."""
    chair, camera = make_furniture("chair", 3), PinholeCamera.xtion()
    orbit = Orbit.around(chair, camera, start=0.5)
    mount = CameraMount.for_orbit(orbit).T_base_camera
    world, stations = Scene.with_object(chair), orbit.stations(60)
    frames = SimulatedCamera(world, stations.__next__, camera, DepthNoise(), 0).frames(STATIONS)
    parts = [struct.pack("<4I", camera.width, camera.height, STATIONS, 16)]
    parts += [struct.pack("<4d", camera.fx, camera.fy, camera.cx, camera.cy)]
    parts += [struct.pack("<7d", *mount.translation, *mount.rotation.as_quat())]
    for number, frame in enumerate(frames):
        place = PlanarPose.from_transform(frame.pose * mount.inv()).as_transform()
        numbers = (100.0 + number / RATE, *place.translation, *place.rotation.as_quat())
        parts += [struct.pack("<8d", *numbers), millimetres(frame.depth).tobytes()]
    path.write_bytes(b"".join(parts))
    return path


class DdsReceiver:
    """The node's DDS without the node; counts received images."""

    def __init__(self, reliable: bool) -> None:
        self._times: list[float] = []
        self._middleware = DdsMiddleware(DdsSettings(DOMAIN, "LOCALHOST"), "")
        wanted = replace(SENSOR, reliable=reliable)
        self._middleware.subscribe(DEPTH, IMAGE, wanted, self._on_message)

    def _on_message(self, data: bytes) -> None:
        self._times.append(time.monotonic())
        assert deserialized(IMAGE, data).width == 640

    def end(self) -> tuple[int, int, str]:
        """Numbers of received and dropped images, and the largest time between two."""
        self._middleware.close()
        return len(self._times), 0, f"{1e3 * float(np.diff(self._times).max()):.0f}"


class NodeReceiver:
    """The whole node at its default rate."""

    def __init__(self, reliable: bool) -> None:
        middleware = DdsMiddleware(DdsSettings(DOMAIN, "LOCALHOST"), "/circumspect")
        classifier = Classifier.load(threads=1)
        self._node = RecognitionNode(
            middleware, NodeSettings(depth=DEPTH, reliable=reliable), classifier
        )
        self._over = threading.Event()
        self._worker = threading.Thread(
            target=self._node.spin, args=(lambda: not self._over.is_set(),)
        )
        self._worker.start()

    def end(self) -> tuple[int, int, str]:
        """Numbers of received images and of dropped frames; times are not recorded."""
        self._over.set()
        self._worker.join()
        self._node.close()
        return self._node.health.count("depth"), self._node.health.dropped, "-"


def measured(
    program: Path, scene_file: Path, reliability: str, requests: bool, seconds: float, node: bool
) -> list[str]:
    """One row: publish for a time [s] and count the received images."""
    receiver = NodeReceiver(requests) if node else DdsReceiver(requests)
    rounds = round(seconds * RATE / STATIONS)
    words = [
        str(program),
        str(DOMAIN),
        "talk",
        str(scene_file),
        str(RATE),
        reliability,
        str(rounds),
    ]
    before, start = time.process_time(), time.monotonic()
    done = subprocess.run(
        words, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=True
    )
    cores = (time.process_time() - before) / (time.monotonic() - start)
    sent = json.loads(done.stdout.splitlines()[-1])["sent"]
    received, dropped, gap = receiver.end()
    what = "names 5 frames/s" if node else "only receives"
    figures = (sent, received, sent - received, dropped)
    requested = "--reliable" if requests else "best effort"
    return [reliability, requested, what, *(str(figure) for figure in figures), gap, f"{cores:.2f}"]


def main() -> int:
    """Measure and write `ros_wire.md`."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    logging.disable(logging.WARNING)
    program, rows = built(), []
    with tempfile.TemporaryDirectory() as folder:
        scene_file = scene(Path(folder) / "scene.bin")
        for node in (False, True):
            for reliability, requests in RELIABILITIES:
                rows.append(
                    measured(program, scene_file, reliability, requests, arguments.seconds, node)
                )
                print(rows[-1], file=sys.stderr)
    limit = Path("/proc/sys/net/core/rmem_max")
    more = {"net.core.rmem_max": limit.read_text().strip()} if limit.exists() else {}
    text = (
        f"640 x 480, 16UC1, {RATE:.0f} Hz for {arguments.seconds:.0f} s over loopback, from "
        "RustDDS to Cyclone DDS. Lost: never received. Dropped: received for the pipeline and "
        "replaced by newer frames. Gap: the largest time between two images. Cores: used by the "
        f"node's process. The load of the machine was {os.getloadavg()[0]:.0f}."
        f"\n\n{table(HEADS, rows)}"
    )
    write_page(
        "ros_wire", "Depth over the wire of ROS 2", "python -m benchmarks.ros_wire", text,
        {"heads": HEADS, "rows": rows}, arguments.out, more,
    )  # fmt: skip
    return 0


if __name__ == "__main__":
    sys.exit(main())
