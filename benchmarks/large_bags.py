"""Memory of `circumspect replay` by size of the bag: python -m benchmarks.large_bags

A robot's recording is enlarged as if its camera had a high frame rate: each depth image is repeated
many times, with a colour image of 1280 x 720 for each. The replay uses only the robot's original
frames, so that the answer must be the same for every size.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections import deque
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.convert.converter import convert
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from benchmarks.report import RESULTS, write_page
from circumspect.evaluation.markdown import table
from circumspect.recording.image_messages import colour_message
from circumspect.recording.ros_types import IMAGE, typestore

DEPTH, COLOUR = "/camera/depth/image_raw", "/camera/aux/image_raw"
COLOUR_SHAPE = (720, 1280, 3)
INTERVAL_S = 2.0
"""Time between frames of the small recording while the robot drives [s]."""
SPAN_S = 0.05
"""Time that contains all repetitions of a frame [s]."""
POLL_S = 0.05
KINDS = ("mcap", "db3", "bag")


def command(*words: object) -> list[str]:
    """Words of a `circumspect` command in a process of its own."""
    return [sys.executable, "-m", "circumspect", *map(str, words)]


def small_recording(folder: Path) -> Path:
    """A robot's scan of a chair with one frame every two seconds."""
    file = folder / "small.mcap"
    words = ("scan", "chair-100000", "--start", 40, "--seed", 5, "--record", file, "--json")
    more = ("--frame-interval", INTERVAL_S, "--out", folder / "scan")
    subprocess.run(command(*words, *more), check=True, capture_output=True)
    return file


def enlarged(small: Path, gigabytes: float, kind: str, folder: Path) -> tuple[Path, int]:
    """The recording enlarged to a size, and the number of repetitions of each depth image."""
    if kind == "bag":
        source, times = enlarged(small, gigabytes, "mcap", folder)
        ros1 = get_typestore(Stores.ROS1_NOETIC)
        bag, filters = folder / "large.bag", ((), (), (), ())
        convert([source.parent], bag, "", 0, None, "", typestore(), ros1, *filters)
        return bag, times
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    store, at = typestore(), folder / kind
    noise = np.random.default_rng(0).integers(0, 256, COLOUR_SHAPE, dtype=np.uint8)
    with AnyReader([small]) as reader, Writer(at, version=9, storage_plugin=plugin) as writer:
        topics = {
            link.topic: writer.add_connection(link.topic, link.msgtype, typestore=store)
            for link in reader.connections
        }
        colour = writer.add_connection(COLOUR, IMAGE, typestore=store)
        depth = next(link for link in reader.connections if link.topic == DEPTH)
        each = noise.nbytes + 2 * 640 * 480
        times = max(1, round(gigabytes * 1e9 / depth.msgcount / each))
        waiting: deque[tuple[int, Any, Any]] = deque()

        def write_before(stamp: float) -> None:
            while waiting and waiting[0][0] < stamp:
                when, topic, message = waiting.popleft()
                writer.write(topic, when, store.serialize_cdr(message, IMAGE))

        for link, stamp, data in reader.messages():
            write_before(stamp)
            writer.write(topics[link.topic], stamp, data)
            if link.topic != DEPTH:
                continue
            image: Any = store.deserialize_cdr(data, IMAGE)
            for number in range(times):
                later = round(1e9 * number * SPAN_S / times)
                if number > 0:
                    waiting.append((stamp + later, topics[DEPTH], delayed(image, later)))
                beside = colour_message(noise, 0.0, "camera_aux")
                beside.header.stamp = delayed(image, later).header.stamp
                waiting.append((stamp + later, colour, beside))
        write_before(np.inf)
    return next(at.glob(f"*.{kind}")), times


def delayed(image: Any, nanoseconds: int) -> Any:
    """The same image with a later time."""
    stamp = image.header.stamp
    seconds, rest = divmod(stamp.nanosec + nanoseconds, 10**9)
    when = replace(stamp, sec=stamp.sec + seconds, nanosec=rest)
    return replace(image, header=replace(image.header, stamp=when))


def replayed(bag: Path, every: int, out: Path) -> dict[str, Any]:
    """Prediction and peak memory [MB] of a replay."""
    words = command("replay", bag, "--every", every, "--out", out, "--json")
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    ) as process:
        peak = 0.0
        while process.poll() is None:
            peak = max(peak, high_water_mb(process.pid))
            time.sleep(POLL_S)
        output = process.stdout.read() if process.stdout else ""
    if process.returncode != 0:
        raise SystemExit(f"{bag}: the replay failed")
    answer = json.loads(output)
    return {
        "gigabytes": bag.stat().st_size / 1e9,
        "peak_mb": peak,
        "label": answer["label"],
        "probability": answer["probability"],
    }


def high_water_mb(process: int) -> float:
    """Peak memory of a process so far, as Linux reports it [MB]; 0 if it has ended."""
    try:
        lines = Path(f"/proc/{process}/status").read_text().splitlines()
    except OSError:
        return 0.0
    found = [line.split()[1] for line in lines if line.startswith("VmHWM")]
    return int(found[0]) / 1e3 if found else 0.0


def main() -> int:
    """Enlarge and replay the bags, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gigabytes", type=float, default=20.0)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--scratch", type=Path, help="folder with space for two such bags")
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory(dir=arguments.scratch) as scratch:
        small = small_recording(Path(scratch))
        for gigabytes, kind in [
            (0.0, "mcap"),
            *((arguments.gigabytes, k) for k in arguments.kinds),
        ]:
            with tempfile.TemporaryDirectory(dir=scratch) as folder:
                bag, times = enlarged(small, gigabytes, kind, Path(folder))
                result = replayed(bag, times, Path(folder) / "run")
            rows.append({"kind": kind, "times": times, **result})
            print(rows[-1], file=sys.stderr)
    cells = [
        [
            f".{row['kind']}, {row['times']} x", f"{row['gigabytes']:.1f}",
            f"{row['peak_mb']:.0f}", f"{row['label']} {row['probability']:.4f}",
        ]
        for row in rows
    ]  # fmt: skip
    text = (
        "A robot's recording with repetitions of each depth image and a colour image of 1280 x 720 "
        "for each. The memory is that of the whole command, which uses each frame once.\n\n"
        + table(["bag", "GB", "most memory [MB]", "answer"], cells)
    )
    line = f"python -m benchmarks.large_bags --gigabytes {arguments.gigabytes:g}"
    write_page("large_bags", "Large bags", line, text, {"rows": rows}, arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
