"""Classifiers without torch: from a point cloud or grid to class probabilities."""

from circumspect.classification.classifier import Classifier
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.evidence import CellEvidence, cell_evidence
from circumspect.classification.example_table import ExampleTable, NearExample, nearest_examples
from circumspect.classification.grid_spec import GridSpec
from circumspect.classification.input_spec import InputSpec
from circumspect.classification.input_spec_dict import input_spec_from_dict
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.points_spec import PointsSpec
from circumspect.classification.prediction import Prediction
from circumspect.classification.shipped import SHIPPED, ShippedClassifier, shipped_path
from circumspect.classification.upright import classify_any_way_up

__all__ = [
    "SHIPPED",
    "CellEvidence",
    "Classifier",
    "ConfidenceRule",
    "ExampleTable",
    "GridSpec",
    "InputSpec",
    "NearExample",
    "OnnxClassifier",
    "PointsSpec",
    "Prediction",
    "ShippedClassifier",
    "cell_evidence",
    "classify_any_way_up",
    "input_spec_from_dict",
    "nearest_examples",
    "shipped_path",
]
