"""From a grid to a name: all that a robot needs of a network, without torch."""

from circumspect.classification.classifier import Classifier
from circumspect.classification.grid_recipe import GridRecipe
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.prediction import Prediction

__all__ = ["Classifier", "GridRecipe", "OnnxClassifier", "Prediction"]
