"""The file scan.json in the folder of a run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from circumspect.exploration.object_scan import ObjectScan
from circumspect.exploration.view_record import ViewRecord
from circumspect.recognition import RecognitionResult, RecognitionStep
from circumspect.storage import write_json


class ScanFile:
    """Writes the end reason of a scan and the outcomes of its views; a `PipelineObserver`."""

    def __init__(self, scan: ObjectScan, path: Path) -> None:
        """Set the scan and the file; nothing is written yet.

        Args:
            scan: The scan.
            path: The JSON file.
        """
        self._scan = scan
        self._path = path

    def on_step(self, step: RecognitionStep) -> None:
        """Do nothing: the log of the run has the steps."""

    def on_end(self, result: RecognitionResult) -> None:  # noqa: ARG002 - the scan knows
        """Write the file.

        Raises:
            OutputError: The file cannot be written.
        """
        self.write({})

    def write(self, more: Mapping[str, Any]) -> None:
        """Write the file again.

        Args:
            more: Additional entries, JSON types.

        Raises:
            OutputError: The file cannot be written.
        """
        scan = self._scan
        document = {
            "ended": scan.ended,
            "distance_m": scan.driven_m,
            "turned_deg": scan.turned_deg,
            "views": [_view_entry(record) for record in scan.views],
            **more,
        }
        write_json(self._path, document)


def _view_entry(record: ViewRecord) -> dict[str, Any]:
    view, base = record.view, record.view.T_map_base
    return {
        "frame": record.frame,
        "outcome": record.reason,
        "why": view.reason,
        "base": {"x": base.x, "y": base.y, "yaw": base.yaw},
        "looks_at": view.looks_at_xy,
        "normal": view.normal_xy,
    }
