"""Files that `locate track` and `locate simulate` write to a run's folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self

from numpy.typing import NDArray

from circumspect.errors import MissingExtraError
from circumspect.folder_lock import FolderLock, lock_folder
from circumspect.geometry import Trajectory, write_tum
from circumspect.localization import Calibration, SpaceTrack, TagMount
from circumspect.runs.run_folder import LOG
from circumspect.storage import require_no_foreign_files, require_writable, write_json

FIXES = "space.jsonl"
"""File that identifies the folder of such a run, unless the log of a scan is beside it."""
RESULTS = (FIXES, "trajectory.txt", "space.png", "result.json")
"""Files of a run; those of an earlier run are removed before new ones are written."""


class LocatedRun:
    """Folder of such a run, locked within `with`; files are written only after the run.

    Attributes:
        path: The folder.
    """

    def __init__(self, path: Path, more: Sequence[str] = ()) -> None:
        """Check before long work that the results can be written.

        Args:
            path: Made if missing. Files of an earlier run in it will be replaced, others are kept.
            more: Names of files that are written in addition to `RESULTS`.

        Raises:
            OutputError: It can not be written, or a file of another kind of run in it would be
                replaced.
        """
        self.path = path
        require_no_foreign_files(path, (*RESULTS, *more), (FIXES, *more), foreign=(LOG,))
        self._lock: FolderLock | None = lock_folder(path)
        require_writable(path)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        # A stack frame that is kept alive, as by a first import of MuJoCo, would keep the lock.
        self._lock = None

    def save(
        self,
        track: SpaceTrack,
        calibration: Calibration,
        mount: TagMount,
        paths: Mapping[str, Trajectory],
        record: Mapping[str, Any],
        truth: Trajectory | None = None,
        walls_xy: Sequence[NDArray[Any]] = (),
        object_xy: NDArray[Any] | None = None,
    ) -> dict[str, Any]:
        """Write trajectory.txt, space.jsonl, result.json and space.png.

        Args:
            track: Poses and rejections of the intelligent space.
            calibration: Calibration of its cameras.
            mount: The tag.
            paths: Other paths for the picture.
            record: Content of result.json.
            truth: True path for the picture.
            walls_xy: Outlines of walls for the picture.
            object_xy: Points of the object for the picture.

        Returns:
            The record with "run", the folder, and "picture_missing" if there is no picture.

        Raises:
            OutputError: A file can not be written.
        """
        document: dict[str, Any] = {**record, "run": str(self.path)}
        for name in RESULTS:
            (self.path / name).unlink(missing_ok=True)
        if (trajectory := track.trajectory()) is not None:
            write_tum(self.path / "trajectory.txt", trajectory)
        track.write_log(self.path / FIXES)
        try:
            from circumspect.evaluation.space_picture import draw_space

            draw_space(
                self.path / "space.png", calibration.cameras, mount.height, track, paths, truth,
                walls_xy, object_xy,
            )  # fmt: skip
        except MissingExtraError as error:
            document["picture_missing"] = str(error)
        write_json(self.path / "result.json", document)
        return document
