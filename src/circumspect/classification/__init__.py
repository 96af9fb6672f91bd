"""From a grid to a name: all that a robot needs of a network, without torch."""

from circumspect.classification.classifier import Classifier
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.evidence import CellEvidence, cell_evidence
from circumspect.classification.example_table import ExampleTable, NearExample, nearest_examples
from circumspect.classification.grid_recipe import GridRecipe
from circumspect.classification.input_recipe import InputRecipe
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.points_recipe import PointsRecipe
from circumspect.classification.prediction import Prediction
from circumspect.classification.recipes import recipe_from_dict
from circumspect.classification.shipped import SHIPPED, ShippedClassifier, shipped_path
from circumspect.classification.upright import classify_any_way_up

__all__ = [
    "SHIPPED",
    "CellEvidence",
    "Classifier",
    "ConfidenceRule",
    "ExampleTable",
    "GridRecipe",
    "InputRecipe",
    "NearExample",
    "OnnxClassifier",
    "PointsRecipe",
    "Prediction",
    "ShippedClassifier",
    "cell_evidence",
    "classify_any_way_up",
    "nearest_examples",
    "recipe_from_dict",
    "shipped_path",
]
