"""Labelled objects for training and evaluation; NumPy only."""

from circumspect.datasets.augmentation import Augmentation
from circumspect.datasets.furniture_set import furniture_set
from circumspect.datasets.grid_cache import GridCache
from circumspect.datasets.labelled_crops import LabelledCrops, read_labelled_crops
from circumspect.datasets.mesh_pack import MeshSet, read_mesh_pack, write_mesh_pack
from circumspect.datasets.object_set import ObjectSet
from circumspect.datasets.open_data_set import open_data_set
from circumspect.datasets.validation_split import validation_split

__all__ = [
    "Augmentation",
    "GridCache",
    "LabelledCrops",
    "MeshSet",
    "ObjectSet",
    "furniture_set",
    "open_data_set",
    "read_labelled_crops",
    "read_mesh_pack",
    "validation_split",
    "write_mesh_pack",
]
