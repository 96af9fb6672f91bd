"""What `locate track` and `locate simulate` leave in a run's folder."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from circumspect.errors import MissingExtraError
from circumspect.geometry import Trajectory, write_tum
from circumspect.localization import Calibration, SpaceTrack, TagMount
from circumspect.storage import atomic_open, write_json

RESULTS = ("space.jsonl", "trajectory.txt", "space.png", "result.json")
"""Those of an earlier track, which the first one tells, are removed from its folder first."""


def save_track(
    folder: Path,
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
        folder: Made where missing.
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
    told: dict[str, Any] = {**record, "run": str(folder)}
    if (folder / RESULTS[0]).exists():
        for name in RESULTS:
            (folder / name).unlink(missing_ok=True)
    if (trajectory := track.trajectory()) is not None:
        write_tum(folder / "trajectory.txt", trajectory)
    with atomic_open(folder / "space.jsonl") as stream:
        stream.writelines(json.dumps(fix.summary()) + "\n" for fix in track.fixes)
    try:
        from circumspect.evaluation.space_picture import draw_space

        picture = folder / "space.png"
        draw_space(
            picture, calibration.cameras, mount.height, track, paths, truth, walls_xy, object_xy
        )
    except MissingExtraError as error:
        told["picture_missing"] = str(error)
    write_json(folder / "result.json", told)
    return told
