"""The training loop on accelerate: `circumspect.training.train`."""

from typing import TYPE_CHECKING

from circumspect.lazy_names import lazy_names

if TYPE_CHECKING:
    from circumspect.training.settings import TrainingSettings
    from circumspect.training.training_changes import TrainingChanges

__all__ = ["TrainingChanges", "TrainingSettings"]
# Commands read the settings of a training before torch is loaded.
__getattr__, __dir__ = lazy_names(
    __name__, {"TrainingChanges": "training_changes", "TrainingSettings": "settings"}
)
