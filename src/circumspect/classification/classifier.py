"""The interface of everything that names an object."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from circumspect.classification.input_recipe import InputRecipe
from circumspect.classification.prediction import Prediction
from circumspect.geometry import PointCloud
from circumspect.grid import OccupancyGrid

if TYPE_CHECKING:
    from circumspect.classification.onnx_classifier import OnnxClassifier


class Classifier(ABC):
    """Names an object, whatever its yaw."""

    @property
    @abstractmethod
    def classes(self) -> tuple[str, ...]:
        """The class names it knows, in the order of its outputs."""

    @property
    @abstractmethod
    def recipe(self) -> InputRecipe:
        """How it wants to be shown clouds."""

    @abstractmethod
    def classify(self, cloud: PointCloud | ArrayLike) -> Prediction:
        """Name the object that a cloud shows.

        Args:
            cloud: The object's surface, z up, any unit and place; only the object. An (n, 3)
                array will do. To a classifier that tells the unknown fewer than 128 distinct points
                tell no class, nor does a cloud that still holds the floor: never `known`.

        Raises:
            GeometryError: The points span no shape: all in one place or on a line.
            InputError: No points: a mesh, a path.
        """

    @abstractmethod
    def classify_grid(self, *views: OccupancyGrid) -> Prediction:
        """Name the object that grids show.

        Args:
            views: One grid of the object, or one for each of `recipe.all_bounds`. With a single
                one the answer is a little less steady between whole azimuth cells.

        Raises:
            InputError: No grid, or one of another kind or shape than the classifier was trained on.
        """

    @staticmethod
    def load(model: str | os.PathLike[str] | None = None, threads: int = 0) -> OnnxClassifier:
        """Load a classifier.

        Args:
            model: The name of a shipped classifier, "robot" or "modelnet10"; or an ONNX file that
                `circumspect export` wrote. None means "robot". A name goes before a file of the
                same name: "./robot" and `Path("robot")` are the file.
            threads: Threads of the network; 0 means as many as there are cores.

        Raises:
            WeightsError: No classifier has this name, or the file is missing, broken, or not a
                circumspect classifier.
        """
        from circumspect.classification.onnx_classifier import OnnxClassifier

        return OnnxClassifier.load(model, threads)
