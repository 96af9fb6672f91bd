"""Recordings that `benchmarks.ablation` runs on."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import RigidTransform

from benchmarks.recorded_scans import read
from circumspect.geometry import PinholeCamera
from circumspect.recording import open_recording
from circumspect.sensing import DepthNoise, RgbdFrame
from circumspect.tracking import TrackingSettings

FURNITURE, FAULTS, KITCHEN = "furniture", "faults", "redkitchen"
REAL = (KITCHEN, "tum_teddy", "realsense_desk")
GROUPS = (FURNITURE, FAULTS, *REAL)
MAX_STAMP_ERROR_S = 0.01
"""Maximum time between a frame and its reference pose [s]; other frames are left out."""


@dataclass(frozen=True)
class Source:
    """A recording.

    Attributes:
        group: One of `GROUPS`.
        path: Its file or folder.
        frames: Maximum number of frames to read; None reads all.
    """

    group: str
    path: Path
    frames: int | None = None

    @property
    def name(self) -> str:
        """Unique name."""
        return self.path.stem if self.group in (FURNITURE, FAULTS) else self.group

    @property
    def key(self) -> str:
        """Name, number of frames and size of the file."""
        return f"{self.name}/{self.frames or 'all'}/{self.path.stat().st_size}"

    @property
    def settings(self) -> TrackingSettings:
        """The defaults for real recordings; simulated depth has no systematic error."""
        simulated = self.group in (FURNITURE, FAULTS)
        if not simulated:
            return TrackingSettings()
        return TrackingSettings.for_noise(DepthNoise(systematic_disparity=0.0))


def scans(folder: Path, every: int, every_fault: int, frames: int | None) -> list[Source]:
    """Recorded scans of a folder, every N-th of each group."""
    paths = sorted(folder.glob("*.npz"))
    if not paths:
        print(f"no scans in {folder}; benchmarks.recorded_scans records them", file=sys.stderr)
    furniture = [path for path in paths if path.name.startswith("none.")]
    faults = [path for path in paths if path not in furniture]
    return [
        *(Source(FURNITURE, path, frames) for path in furniture[::every]),
        *(Source(FAULTS, path, frames) for path in faults[::every_fault]),
    ]


def real(folder: Path, frames: int | None) -> list[Source]:
    """The real recordings that a folder contains."""
    found = []
    for name in REAL:
        path = folder / name if name == KITCHEN else folder / name / "frames.npz"
        if path.exists():
            found.append(Source(name, path, frames))
        else:
            print(f"{name} is skipped: there is no {path}", file=sys.stderr)
    return found


@lru_cache(maxsize=1)
def loaded(source: Source) -> tuple[Sequence[RgbdFrame], RigidTransform]:
    """Frames and all true poses; the first frame of a real recording has a pose."""
    if source.group in (FURNITURE, FAULTS):
        scan = read(source.path)
        return scan.frames[: source.frames], scan.truth[: source.frames]
    if source.group == KITCHEN:
        posed = list(islice(open_recording(source.path), source.frames))
    else:
        posed = _read_posed(source.path)[: source.frames]
    truth = RigidTransform.concatenate([frame.pose for frame in posed])
    return [posed[0], *(replace(frame, T_map_camera=None) for frame in posed[1:])], truth


def _read_posed(path: Path) -> list[RgbdFrame]:
    frames = []
    with np.load(path) as data:
        images, offsets, poses = data["depth_png"], data["depth_off"], data["pose"]
        scale, stamps = float(data["depth_scale"]), data["stamp"]
        camera = None
        for n in np.flatnonzero(data["pose_dt"] <= MAX_STAMP_ERROR_S):
            encoded = images[offsets[n] : offsets[n + 1]]
            depth = np.asarray(cv2.imdecode(encoded, cv2.IMREAD_UNCHANGED), np.float32)
            depth /= scale
            depth[depth <= 0] = np.nan
            if camera is None:
                camera = PinholeCamera(depth.shape[1], depth.shape[0], *map(float, data["K"]))
            pose = RigidTransform.from_matrix(poses[n])
            frames.append(RgbdFrame(depth, camera, float(stamps[n]), pose))
    return frames
