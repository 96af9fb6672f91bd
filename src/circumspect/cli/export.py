"""`circumspect export`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from circumspect.errors import MissingExtraError


@dataclass(frozen=True)
class Export:
    """Turn trained networks into one ONNX file for the robot.

    $ circumspect export runs/train-planes planes.onnx
    $ circumspect export runs/a committee.onnx --committee runs/b runs/c
    """

    weights: Annotated[Path, tyro.conf.Positional]
    """A checkpoint, or the folder of a run."""
    out: Annotated[Path, tyro.conf.Positional]
    """The ONNX file to write; it is kept only if its outputs equal the checkpoint's."""
    committee: tuple[Path, ...] = ()
    """Further checkpoints or runs, whose logits are averaged with the first's."""
    azimuth_views: int = 1
    """Average over this many grids an object, turned by fractions of an azimuth cell."""
    temperature: float = 1.0
    """Divides the logits: above 1 makes the classifier less sure."""

    def run(self) -> int:
        """Export and tell how close the outputs are."""
        try:
            from circumspect.export import export_onnx
        except ImportError as error:
            raise MissingExtraError("torch or onnx", "train") from error
        from circumspect.evaluation.predictor import checkpoint_path
        from circumspect.nets import Checkpoint

        paths = (self.weights, *self.committee)
        members = [Checkpoint.load(checkpoint_path(path)) for path in paths]
        difference = export_onnx(members, self.out, self.azimuth_views, self.temperature)
        size = self.out.stat().st_size / 1e6
        print(f"{self.out}: {size:.1f} MB, logits within {difference:.1g}")  # noqa: T201
        return 0
