"""One readable training loop on accelerate."""

from circumspect.training.settings import TrainingSettings
from circumspect.training.train import train

__all__ = ["TrainingSettings", "train"]
