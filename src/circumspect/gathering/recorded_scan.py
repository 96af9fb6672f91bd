"""A recording of a real robot as a scan of a gathered set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from circumspect import __version__
from circumspect.datasets.gathered_set import (
    GatheredScan,
    is_gathered,
    read_manifest,
)
from circumspect.errors import InputError
from circumspect.gathering.scan_files import scan_quality, write_scan
from circumspect.gathering.set_place import SetFolder
from circumspect.geometry import TrajectoryLog
from circumspect.recognition import (
    PipelineObserver,
    RecognitionPipeline,
    RecognitionResult,
    run_pipeline,
)
from circumspect.sensing import RgbdFrame


@dataclass(frozen=True)
class RecordedObject:
    """The object in a recording.

    Attributes:
        label: Its class.
        name: The object's own name; all its scans are in one split.
        split: train or test; None means the object's split in the set, train for a new object.
        start_deg: Azimuth of the start [degrees], if measured.
    """

    label: str
    name: str
    split: Literal["train", "test"] | None = None
    start_deg: float | None = None

    def __post_init__(self) -> None:
        for text in (self.label, self.name):
            if not text or not all(c.isalnum() or c in "_-." for c in text) or text[0] == ".":
                raise InputError(f"{text!r}: a name is made of letters, digits, _, - and .")
        if self.start_deg is not None and not 0 <= self.start_deg < 360:
            raise InputError(f"--start {self.start_deg:g}: give degrees from 0 up to 360")


def recording_name(recording: Path) -> str:
    """The name of a recording: a file without its suffix, or a folder."""
    whole = recording.resolve()
    return whole.name if whole.is_dir() else whole.stem


class RecordedScan:
    """A recording that becomes a scan of a set."""

    def __init__(
        self, folder: Path, recording: Path, shown: RecordedObject, replaces: bool = False
    ) -> None:
        """Check whether the set can take it.

        Args:
            folder: Of the set; may be missing.
            recording: A bag or a folder; the scan is named after it.
            shown: Its object.
            replaces: Replace a scan of the same name; the object's other scans get its class and
                split. A scan without its object is replaced in any case.

        Attributes:
            split: train or test, as given or as the set has the object.
            changed: Scans of the object that the set has with another class or split, as they are
                before `gather`.

        Raises:
            InputError: It is in the set already, another scan of the object has another split or
                class, or the folder holds something else.
        """
        self._folder, self._recording, self._shown = folder, recording, shown
        self._name = f"{shown.name}@{recording_name(recording)}"
        there: list[GatheredScan] = []
        if is_gathered(folder):
            there = [scan for scan in read_manifest(folder) if scan.object == shown.name]
        else:
            SetFolder(folder).require_free()
        held = there[0].split if there else "train"
        self.split: Literal["train", "test"] = shown.split or held
        self._before = next((scan for scan in there if scan.scan == self._name), None)
        other_kind = [s for s in there if (s.split, s.label) != (self.split, shown.label)]
        self._others = [scan for scan in other_kind if scan is not self._before]
        self.changed = other_kind
        if self._before is not None and "cloud" in self._before.files and not replaces:
            source = self._before.quality.get("recording", "a simulated scan")
            raise InputError(
                f"{folder}: holds {self._name} already, of {source}; --replace puts this recording "
                "in its place"
            )
        if self._others and not (replaces and self._before is not None):
            raise self._other_kind(self._others[0])

    def gather(
        self,
        frames: Iterable[RgbdFrame],
        pipeline: RecognitionPipeline,
        reading: Mapping[str, Any] | None = None,
        observers: Sequence[PipelineObserver] = (),
    ) -> GatheredScan:
        """Process all frames and add the result to the set.

        Args:
            frames: Of the recording.
            pipeline: Processes them.
            reading: Settings of the reader that differ from the default; JSON types.
            observers: Notified of every frame and of the end.

        Raises:
            InputError: No frame can be read, or none showed the object; nothing is added.
            OutputError: A file cannot be written.
        """
        wheels = _OdometryRecorder()
        given = (wheels.recorded(frame) for frame in frames)
        result = run_pipeline(pipeline, given, observers)
        if result.last is None or result.last.grid is None:
            reasons = ", ".join(sorted({step.outcome for step in result.steps})) or "no frames"
            raise InputError(
                f"{self._recording}: shows no object in {len(result.steps)} frames ({reasons}); "
                f"nothing was added to {self._folder}; where it does show one, say by --box or "
                "--mount how it is to be read"
            )
        place = SetFolder(self._folder)
        if not place.is_begun():
            place.begin({"source": "recordings"})
        scan = self._scan(result, wheels, dict(reading or {}))
        place.add(scan)
        for other in self._others:
            place.add(replace(other, label=scan.label, split=scan.split))
        self._drop_what_is_left_of_before(scan)
        return scan

    def _other_kind(self, scan: GatheredScan) -> InputError:
        return InputError(
            f"{self._folder}: {scan.object} is a {scan.label} of the {scan.split} split there, "
            f"as in {scan.scan}; all scans of an object belong together: give the same "
            "--label and --split, or another --name, or --replace one that is there"
        )

    def _scan(
        self, result: RecognitionResult, wheels: _OdometryRecorder, reading: dict[str, Any]
    ) -> GatheredScan:
        shown = self._shown
        # Recordings are added over years: each records the version that replayed it.
        quality = {
            **scan_quality(result),
            "recording": self._recording.name,
            "reading": reading,
            "version": __version__,
        }
        files = write_scan(self._folder, self._name, result, wheels.log.trajectory)
        return GatheredScan(
            self._name, shown.name, shown.label, self.split, shown.start_deg, files, quality
        )

    def _drop_what_is_left_of_before(self, scan: GatheredScan) -> None:
        """Delete files of the replaced scan that this one lacks."""
        there = {} if self._before is None else self._before.files
        for name in set(there.values()) - set(scan.files.values()):
            (self._folder / name).unlink(missing_ok=True)


class _OdometryRecorder:
    """Records the camera's path by wheel odometry."""

    def __init__(self) -> None:
        self.log = TrajectoryLog()

    def recorded(self, frame: RgbdFrame) -> RgbdFrame:
        if (T_odom_camera := frame.T_odom_camera) is not None:
            self.log.add(frame.stamp, T_odom_camera)
        return frame
