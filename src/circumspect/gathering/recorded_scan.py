"""A recording of a real robot as a scan of a gathered set."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from scipy.spatial.transform import RigidTransform

from circumspect import __version__
from circumspect.classification import Classifier
from circumspect.datasets.gathered_set import (
    GatheredScan,
    is_gathered,
    read_manifest,
)
from circumspect.errors import InputError
from circumspect.gathering.gather import append, begin
from circumspect.gathering.scan_files import told_quality, write_scan
from circumspect.pipeline.camera_path import increasing
from circumspect.pipeline.replayed import replay_pipeline
from circumspect.recording import GivenPoses, open_recording
from circumspect.sensing import RgbdFrame


@dataclass(frozen=True)
class RecordedObject:
    """What a recording shows.

    Attributes:
        label: Its class.
        name: The object's own name; all scans of it are of one split.
        split: train or test.
        start_deg: Azimuth of the start [degrees], where somebody measured it.
    """

    label: str
    name: str
    split: Literal["train", "test"] = "train"
    start_deg: float | None = None

    def __post_init__(self) -> None:
        for text in (self.label, self.name):
            if not text or not all(c.isalnum() or c in "_-." for c in text) or text[0] == ".":
                raise InputError(f"{text!r}: a name is made of letters, digits, _, - and .")
        if self.start_deg is not None and not 0 <= self.start_deg < 360:
            raise InputError(f"--start {self.start_deg:g}: give degrees from 0 up to 360")


def gather_recording(folder: Path, recording: Path, shown: RecordedObject) -> GatheredScan:
    """Replay a recording and add what comes out to a set.

    Args:
        folder: Of the set; made where missing.
        recording: A bag.
        shown: What it shows.

    Raises:
        InputError: It can not be replayed, is in the set already, or another scan of the object
            is of another split or class.
        OutputError: A file can not be written.
    """
    scans = read_manifest(folder) if is_gathered(folder) else []
    name = f"{shown.name}@{recording.stem}"
    for scan in scans:
        if scan.scan == name:
            raise InputError(f"{folder}: holds {name} already")
        if scan.object == shown.name and (scan.split, scan.label) != (shown.split, shown.label):
            raise InputError(
                f"{folder}: {shown.name} is a {scan.label} of the {scan.split} split there; all "
                "scans of an object belong together"
            )
    frames = open_recording(recording, poses=GivenPoses.NONE)
    pipeline = replay_pipeline(frames, Classifier.load())
    wheels = _Wheels()
    result = pipeline.run(wheels.heard(frame) for frame in frames.placed())
    if not is_gathered(folder):
        begin(folder, {"source": "recordings"})
    # Recordings are added over years: each says which version replayed it.
    quality = {**told_quality(result), "recording": recording.name, "version": __version__}
    files = write_scan(folder, name, result, increasing(wheels.told))
    scan = GatheredScan(name, shown.name, shown.label, shown.split, shown.start_deg, files, quality)
    append(folder, scan)
    return scan


class _Wheels:
    """Keeps where the wheels say the camera was."""

    def __init__(self) -> None:
        self.told: list[tuple[float, RigidTransform]] = []

    def heard(self, frame: RgbdFrame) -> RgbdFrame:
        if (T_odom_camera := frame.T_odom_camera) is not None:
            self.told.append((frame.stamp, T_odom_camera))
        return frame
