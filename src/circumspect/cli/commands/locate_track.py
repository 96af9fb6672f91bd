"""`circumspect locate track`."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from circumspect.cli.config_file import ConfigFlag, write_config
from circumspect.cli.say import say
from circumspect.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from circumspect.geometry import Trajectory
    from circumspect.localization import CeilingImage, SpaceTrack
    from circumspect.localization.image_folder import ImageFolder
    from circumspect.recording import CeilingBag


REASONS = 3
"""Number of printed reasons for times without a pose."""


@dataclass(frozen=True)
class Track:
    """Track the robot in recorded images of ceiling cameras.

    $ circumspect locate track images --calibration calibration.json
    $ circumspect locate track images --calibration room.json --json
    $ circumspect locate track run.mcap --calibration room.json
    """

    images: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FOLDER|BAG")]
    """Bag of ROS 1 or 2, or folder with one sub-folder per camera, named after it. The name of an
    image is its stamp [s], such as 12.340.png, or stamps.txt beside it has lines NAME SECONDS."""
    calibration: Path
    """Calibration file with intrinsics and poses of the cameras."""
    tag: tuple[int, float, float] | None = None
    """The robot's tag: number, size [m], height above the floor [m]; by default from the
    calibration file, which also contains its position on the robot."""
    topic: Annotated[tuple[str, ...], tyro.conf.arg(metavar="CAMERA=TOPIC")] = ()
    """Bags only: topics that are not named after their camera as /ceiling_0/image_raw is."""
    odometry: Path | None = None
    """Path from wheel odometry in the frame map, TUM format; drawn in the picture."""
    truth: Path | None = None
    """True poses of base_link in the frame map, TUM format; the error is printed."""
    out: Path | None = None
    """Folder of the run; runs/track-DATE-TIME by default."""
    json: bool = False
    """Print one JSON line on standard output and nothing else."""
    config: ConfigFlag = None

    def run(self) -> int:
        """Detect tags, fuse poses, write and draw the trajectory."""
        import time

        from circumspect.cli.located_run import LocatedRun
        from circumspect.cli.progress import progress_bar
        from circumspect.cli.run_screen import new_run_folder
        from circumspect.geometry import read_tum
        from circumspect.localization import (
            IntelligentSpace,
            SpaceTrack,
            read_calibration,
        )

        calibration = read_calibration(self.calibration)
        images = self._opened([camera.name for camera in calibration.cameras])
        mount = calibration.mount_with(self.tag)
        if mount is None:
            raise InputError(
                f"{self.calibration}: says nothing of the robot's tag; "
                "give --tag NUMBER SIZE HEIGHT"
            )
        truth = None if self.truth is None else read_tum(self.truth)
        paths = {} if self.odometry is None else {"odometry alone": read_tum(self.odometry)}
        with LocatedRun(self.out or new_run_folder("track")) as located:
            space = IntelligentSpace(calibration.cameras, mount)
            began = time.perf_counter()
            with progress_bar("images") as progress:
                fixes = list(space.track(_counted(images, progress)))
            spent = time.perf_counter() - began
            if images.skipped and not fixes:
                name, reason = next(iter(images.skipped.items()))
                raise InputError(
                    f"{self.images}: no image can be read; the first: {name}: {reason}"
                )
            track = SpaceTrack.of(fixes, space.reports)
            record: dict[str, Any] = {
                **track.summary(),
                "images": len(images),
                "skipped": images.skipped,
                "images_per_second": len(images) / spent,
                "error": None if truth is None else self._error(track, truth),
            }
            record = located.save(track, calibration, mount, paths, record, truth)
            write_config(located.path, self, "locate track")
        for name, reason in images.skipped.items():
            say(f"left out: {name}: {reason}")
        print(json.dumps(record) if self.json else _summary(record))  # noqa: T201
        return 0

    def _error(self, track: SpaceTrack, truth: Trajectory) -> dict[str, Any] | None:
        """Error against the truth; a failed comparison is reported and does not end the command."""
        from circumspect.evaluation.space_error import space_error

        try:
            return space_error(track, truth).to_dict()
        except InputError as error:
            say(f"{self.truth}: {error}")
            return None

    def _opened(self, known: list[str]) -> ImageFolder | CeilingBag:
        """Open the images; cameras without calibration are reported first.

        Args:
            known: Names of the calibrated cameras.
        """
        from circumspect.localization.image_folder import ImageFolder
        from circumspect.recording import CeilingBag, is_bag, open_bag

        topics = dict(self._topic(words) for words in self.topic)
        if len(topics) < len(self.topic):
            raise InputError("--topic names a camera twice; give one topic each")
        if is_bag(self.images):
            self._require(tuple(topics), known)
            return CeilingBag(open_bag(self.images), known, topics)
        if topics:
            raise InputError(f"{self.images}: is not a bag; --topic is for topics of a bag")
        folder = ImageFolder(self.images)
        self._require(folder.cameras, known)
        return folder

    def _require(self, named: tuple[str, ...], known: list[str]) -> None:
        strangers = [name for name in named if name not in known]
        if strangers:
            raise InputError(
                f"{self.calibration}: knows no place of camera '{strangers[0]}'; known: "
                f"{', '.join(known) or 'none'}; find it with: circumspect locate extrinsics"
            )

    def _topic(self, words: str) -> tuple[str, str]:
        camera, equals, topic = words.partition("=")
        if not (camera and equals and topic):
            raise InputError(f"--topic {words}: give CAMERA=TOPIC, as ceiling_0=/up/image_raw")
        return camera, topic


def _counted(
    images: ImageFolder | CeilingBag, progress: Callable[[int, int], None]
) -> Iterator[CeilingImage]:
    for done, image in enumerate(images, start=1):
        progress(done, len(images))
        yield image


def _summary(record: dict[str, Any]) -> str:
    states = record["states"]
    lines = [
        f"Located {states.get('tracked', 0)} of {record['times']} times, "
        f"{states.get('bridged', 0)} bridged, {states.get('lost', 0)} lost."
    ]
    if states.get("lost", 0):
        reasons = list(record["rejected"].items())[:REASONS]
        lines += [f"{count} times {reason}" for reason, count in reasons]
    if record["space_error_m"] is not None:
        lines.append(
            f"Stated error: {1e3 * record['space_error_m']:.2f} mm, "
            f"{record['space_yaw_error_deg']:.3f}°."
        )
    if record["error"] is not None:
        error = record["error"]
        lines.append(
            f"Against the truth: {1e3 * error['position_rmse_m']:.2f} mm RMSE, "
            f"{1e3 * error['position_max_m']:.2f} mm at most; {error['yaw_rmse_deg']:.3f}°."
        )
    lines += record["reports"]
    lines.append(f"All of it is in {record['run']}; begin with space.png there")
    return "\n".join(lines)
