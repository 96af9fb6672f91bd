"""What `locate track` and `locate simulate` leave in a run's folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from circumspect.errors import MissingExtraError
from circumspect.folder_lock import lock_folder
from circumspect.geometry import Trajectory, write_tum
from circumspect.localization import Calibration, SpaceTrack, TagMount
from circumspect.runs.run_folder import LOG
from circumspect.storage import require_no_strangers, require_writable, write_json

FIXES = "space.jsonl"
"""What makes a folder that of such a run, unless a scan's log is beside it."""
RESULTS = (FIXES, "trajectory.txt", "space.png", "result.json")
"""Those of an earlier run are removed when one is written down."""


class LocatedRun:
    """The folder of such a run; nothing is written before the run is over.

    Attributes:
        path: The folder.
    """

    def __init__(self, path: Path, more: Sequence[str] = ()) -> None:
        """Find out before long work whether its results can be written.

        Args:
            path: Made where missing. Files of an earlier run in it will be replaced, others are
                left alone.
            more: Names of files that are written beside `RESULTS`.

        Raises:
            OutputError: It can not be written, or holds a file that is of no such run and would
                be replaced.
        """
        self.path = path
        require_no_strangers(path, (*RESULTS, *more), (FIXES, *more), foreign=(LOG,))
        self._lock = lock_folder(path)
        require_writable(path)

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
            track: What the intelligent space said.
            calibration: Of its cameras.
            mount: The tag.
            paths: Other paths for the picture.
            record: What is told of the run.
            truth: For the picture.
            walls_xy: For the picture.
            object_xy: For the picture.

        Returns:
            The record with "run", the folder, and "picture_missing" where there is none.

        Raises:
            OutputError: A file can not be written.
        """
        told: dict[str, Any] = {**record, "run": str(self.path)}
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
            told["picture_missing"] = str(error)
        write_json(self.path / "result.json", told)
        return told
