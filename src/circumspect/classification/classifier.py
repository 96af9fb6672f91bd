"""The interface of classifiers."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from circumspect.classification.input_spec import InputSpec
from circumspect.classification.prediction import Prediction
from circumspect.geometry import PointCloud
from circumspect.grid import OccupancyGrid

if TYPE_CHECKING:
    from circumspect.classification.onnx_classifier import OnnxClassifier


class Classifier(ABC):
    """Classify objects; the result does not depend on their yaw."""

    @property
    @abstractmethod
    def classes(self) -> tuple[str, ...]:
        """Class names in the order of the outputs."""

    @property
    @abstractmethod
    def input_spec(self) -> InputSpec:
        """How clouds become the classifier's inputs."""

    @abstractmethod
    def classify(
        self,
        cloud: PointCloud | ArrayLike,
        *,
        metric: bool = False,
        coverage: float | None = None,
    ) -> Prediction:
        """Classify the object in a cloud.

        Args:
            cloud: The object's surface, z up, in any place, without other things; a `PointCloud` or
                an (n, 3) array. A classifier that recognises unknown objects never reports
                `in_distribution` for fewer than 128 distinct points or for a cloud with a floor.
            metric: The points are in metres; without it their scale counts as unknown.
            coverage: Share of the azimuth from which it was seen, 0 … 1; None where unknown.

        Raises:
            GeometryError: The points span no shape: all in one place or on a line.
            InputError: No points: a mesh, a path; an implausible size in metres; an unknown
                scale with a classifier that requires one; or a coverage that is no share.
        """

    @abstractmethod
    def classify_grid(
        self, *views: OccupancyGrid, metric: bool = False, coverage: float | None = None
    ) -> Prediction:
        """Classify the object in grids.

        Args:
            views: One grid of the object, or one for each of `input_spec.all_bounds`. The answer
                from a single grid varies slightly more between whole azimuth cells.
            metric: Their bounds are in metres; without it the scale counts as unknown.
            coverage: Share of the azimuth from which the object was seen, 0 … 1; None where
                unknown.

        Raises:
            InputError: No grid, or one of another kind or shape than the classifier was trained
                on; an unknown scale where one is required; or a coverage that is no share.
        """

    @staticmethod
    def load(
        model: str | os.PathLike[str] | None = None,
        threads: int = 0,
        input_spec: str | os.PathLike[str] | None = None,
    ) -> OnnxClassifier:
        """Load a classifier.

        Args:
            model: The name of a shipped classifier, "robot" or "modelnet10"; or an ONNX file, of
                `circumspect export` or of another program. None means "robot". A name goes before
                a file of the same name: "./robot" and `Path("robot")` are the file.
            threads: Threads of the network; 0 means as many as there are cores.
            input_spec: TOML or JSON file that describes an ONNX file of another program; None
                means NAME.input.toml or NAME.input.json beside NAME.onnx.

        Raises:
            WeightsError: No classifier has this name, or the file is missing, broken, of another
                program and not described, or not as the description says.
            InputError: The input specification is missing or broken.
        """
        from circumspect.classification.onnx_classifier import OnnxClassifier

        return OnnxClassifier.load(model, threads, input_spec)
