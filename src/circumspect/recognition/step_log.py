"""The steps of a run in bounded memory a frame."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.geometry.growing_table import GrowingTable
from circumspect.recognition.recognition_step import RecognitionStep
from circumspect.reconstruction import ModelSettings, ObjectModel
from circumspect.tracking import PoseEstimate

_CAMERA, _REFERENCE, _COVARIANCE, _COLUMNS = slice(0, 16), slice(16, 32), slice(32, 68), 68
_ELSEWHERE = RigidTransform.identity()
"""Stands in for a pose whose numbers are in the table."""


class StepLog:
    """Keeps the latest step whole, and earlier ones without model and grid.

    Poses and covariances are in one table.
    """

    def __init__(self) -> None:
        """Start empty."""
        self._steps: list[RecognitionStep] = []
        self._poses = GrowingTable(_COLUMNS)

    def append(self, step: RecognitionStep) -> None:
        """Add the next step."""
        if self._steps:
            self._steps[-1] = self._packed(self._steps[-1])
        self._steps.append(step)

    @property
    def steps(self) -> list[RecognitionStep]:
        """All steps so far; only the latest holds model and grid."""
        rows = self._poses.rows
        before = [_unpacked(step, row) for step, row in zip(self._steps, rows, strict=False)]
        return [*before, *self._steps[len(rows) :]]

    def _packed(self, step: RecognitionStep) -> RecognitionStep:
        pose = step.pose
        self._poses.append(np.full(_COLUMNS, np.nan) if pose is None else _row(pose))
        if pose is not None:
            pose = replace(pose, T_map_camera=_ELSEWHERE, T_reference_camera=None, covariance=None)
        model = _without_surface(step.model.settings)
        return replace(step, model=model, grid=None, pose=pose)


def _row(pose: PoseEstimate) -> NDArray[np.float64]:
    """The numbers of a pose; NaN for missing ones."""
    row = np.full(_COLUMNS, np.nan)
    row[_CAMERA] = pose.T_map_camera.as_matrix().ravel()
    if pose.T_reference_camera is not None:
        row[_REFERENCE] = pose.T_reference_camera.as_matrix().ravel()
    if pose.covariance is not None:
        row[_COVARIANCE] = pose.covariance.ravel()
    return row


def _unpacked(step: RecognitionStep, row: NDArray[np.float64]) -> RecognitionStep:
    if step.pose is None:
        return step
    camera, in_reference = _transform(row[_CAMERA]), _transform(row[_REFERENCE])
    assert camera is not None
    covariance = None if np.isnan(row[_COVARIANCE.start]) else row[_COVARIANCE].reshape(6, 6)
    pose = replace(
        step.pose, T_map_camera=camera, T_reference_camera=in_reference, covariance=covariance
    )
    return replace(step, pose=pose)


def _transform(numbers: NDArray[np.float64]) -> RigidTransform | None:
    # Not normalised again: the pose is restored exactly.
    return None if np.isnan(numbers[0]) else RigidTransform(numbers.reshape(4, 4), normalize=False)


@lru_cache(maxsize=4)
def _without_surface(settings: ModelSettings) -> ObjectModel:
    """One empty model for all steps."""
    return ObjectModel(settings)
