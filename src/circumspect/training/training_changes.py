"""Requested changes of training settings; importable without heavy packages."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Any, Literal

OF_OBJECTS = ("stretch", "partial", "damage")
"""Names of the settings of `Augmentation`."""


@dataclass(frozen=True)
class TrainingChanges:
    """Changes of the default training settings of a network; None means no change.

    The metadata "off" of a field is the help text of the flag that disables it.

    Attributes:
        epochs: Number of epochs. After each, the held-back objects are classified and the progress
            is saved.
        passes: Number of passes through the set in an epoch. Default: 1; for a small set, the
            number that gives about 500 objects.
        batch_size: Number of objects in a batch.
        learning_rate: Maximum learning rate.
        mixing: Fraction of the batches in which each object is blended with another (mixup), 0 … 1.
        balance: 1 draws all classes equally often, 0 draws all objects equally often.
        label_smoothing: Fraction of the target that is spread over all classes.
        replicas: Number of augmented variants of each object, which are cached (4 kB each).
        furniture: Fraction of the draws that are procedural furniture, 0 … 1.
        stretch: Maximum relative change of the scale of each axis in augmentation.
        partial: Fraction of the variants that contain only the part of the object visible in a
            partial scan, 0 … 1.
        damage: Fraction of the variants with a large missing part, a tilt or floating points,
            0 … 1.
        scans: Train on simulated scans, as of a robot: from one view to a full orbit, with
            visibility, size in metres and a class of other things.
        catalogue_share: With --catalogue: fraction of the draws that are catalogue objects, 0 … 1.
        catalogue_replicas: With --catalogue: number of scans of each catalogue object, which are
            cached (8 kB each).
        furniture_each: With --furniture: number of pieces of each category.
        furniture_others: With --furniture and --scans: number of things of each other kind.
        draws: With --scans: number of objects in an epoch; that of the set by default.
        random_yaw: Turn every variant of every object about the vertical by a random angle, as in
            the papers of VoxNet, 3DShapeNets and PointNet. The network then learns to handle turns.
            Without this flag it is trained at 0° alone, like the shipped classifiers and all
            results that are not labelled otherwise.
        validation: Hold objects back. With 100 or more of them, the epoch with the best accuracy on
            them is kept, otherwise the last one.
        validation_salt: Text that selects the held-back objects; another text selects others.
        precision: Numeric precision; bf16 is automatic mixed precision.
        seed: Random seed.
    """

    epochs: int | None = None
    passes: int | None = None
    batch_size: int | None = None
    learning_rate: float | None = None
    mixing: float | None = None
    balance: float | None = None
    label_smoothing: float | None = None
    replicas: int | None = None
    furniture: float | None = None
    stretch: float | None = None
    partial: float | None = None
    damage: float | None = None
    scans: bool = False
    catalogue_share: float | None = None
    catalogue_replicas: int | None = None
    furniture_each: int | None = None
    furniture_others: int | None = None
    draws: int | None = None
    random_yaw: bool = False
    validation: bool = field(
        default=True,
        metadata={
            "off": "Train on all objects and keep the last epoch. By default some objects are held "
            "back; with 100 or more of them, the epoch with the best accuracy on them is kept."
        },
    )
    validation_salt: str = ""
    precision: Literal["fp32", "bf16"] = "fp32"
    seed: int = 0

    def of_run(self) -> dict[str, Any]:
        """The given changes of `TrainingSettings`, by name."""
        given = self._given([one.name for one in fields(self) if one.name not in OF_OBJECTS])
        if "catalogue_share" in given:
            given["catalogue"] = given.pop("catalogue_share")
        return given

    def of_objects(self) -> dict[str, Any]:
        """The given changes of `Augmentation`, by name."""
        return self._given(OF_OBJECTS)

    def _given(self, names: Iterable[str]) -> dict[str, Any]:
        given = {name: getattr(self, name) for name in names}
        return {name: value for name, value in given.items() if value is not None}
