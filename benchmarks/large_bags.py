"""Memory of `circumspect replay` as a bag grows: python -m benchmarks.large_bags

A robot's recording is written again as a camera of many frames a second would have filled it: each
depth image many times over, and a colour image of 1280 x 720 beside each. The replay takes the
robot's own frames out of it, so that it must give the same answer for every size.
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
"""Between the small recording's frames, when the robot does not stand and look [s]."""
SPAN_S = 0.05
"""Of each of its frames, all repetitions are within this time [s]."""
POLL_S = 0.05
KINDS = ("mcap", "db3", "bag")


def command(*words: object) -> list[str]:
    """The command line, as a process of its own."""
    return [sys.executable, "-m", "circumspect", *map(str, words)]


def small_recording(folder: Path) -> Path:
    """A robot's scan of a chair, a frame each two seconds."""
    file = folder / "small.mcap"
    words = ("scan", "chair-100000", "--start", 40, "--seed", 5, "--record", file, "--json")
    more = ("--frame-interval", INTERVAL_S, "--out", folder / "scan")
    subprocess.run(command(*words, *more), check=True, capture_output=True)
    return file


def grown(small: Path, gigabytes: float, kind: str, folder: Path) -> tuple[Path, int]:
    """The same recording with so many bytes, and how many times each depth image is in it."""
    if kind == "bag":
        source, times = grown(small, gigabytes, "mcap", folder)
        ros1 = get_typestore(Stores.ROS1_NOETIC)
        bag, everything = folder / "large.bag", ((), (), (), ())
        convert([source.parent], bag, "", 0, None, "", typestore(), ros1, *everything)
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
    """Its prediction and the largest memory [MB]."""
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
    """The most memory that a process had so far, by Linux's own count; 0 where it has ended."""
    try:
        lines = Path(f"/proc/{process}/status").read_text().splitlines()
    except OSError:
        return 0.0
    found = [line.split()[1] for line in lines if line.startswith("VmHWM")]
    return int(found[0]) / 1e3 if found else 0.0


def main() -> int:
    """Grow, replay, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gigabytes", type=float, default=20.0)
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--scratch", type=Path, help="a folder with room for two such bags")
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
                bag, times = grown(small, gigabytes, kind, Path(folder))
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
        "A robot's recording, each depth image so many times and with it a colour image of "
        "1280 x 720; the whole command, which takes each frame once.\n\n"
        + table(["bag", "GB", "most memory [MB]", "answer"], cells)
    )
    line = f"python -m benchmarks.large_bags --gigabytes {arguments.gigabytes:g}"
    write_page("large_bags", "Large bags", line, text, {"rows": rows}, arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
