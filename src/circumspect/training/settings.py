"""The settings of a training run."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

from circumspect.datasets import Augmentation
from circumspect.datasets.scan_augmentation import ScanAugmentation
from circumspect.errors import CircumspectError, InputError
from circumspect.nets.registry import NetSpec
from circumspect.plugins import PluginError
from circumspect.training.training_changes import TrainingChanges


@dataclass(frozen=True)
class TrainingSettings:
    """Everything that defines a run; written to its folder.

    Attributes:
        net: Name of the network.
        epochs: Number of epochs; after each, the held-back objects are classified and progress is
            saved.
        passes: Passes through the set per epoch; `passes_for` recommends a number for small sets.
        batch_size: Objects per step, over all processes.
        learning_rate: Peak learning rate, after linear warm-up and before cosine decay.
        warm_up: Fraction of the run until the peak.
        optimizer: "adamw", or "sgd" with a momentum of 0.9.
        weight_decay: Weight decay of weights with two or more dimensions.
        label_smoothing: Fraction of the target distributed over all classes.
        averaging: Decay per step of the averaged weights, which are stored.
        mixing: Fraction of the batches with mixup (Zhang et al. 2018) of each grid with another;
            the larger weight is drawn from Beta(0.4, 0.4).
        balance: 1 draws all classes equally often, 0 all objects.
        heading: Weight of the heading loss, for networks with a heading output.
        furniture: Fraction of procedural furniture in the draws.
        furniture_each: Number of pieces per category.
        scans: Train on simulated scans, with visibility, size and a class of other objects.
        scan: Settings of these scans.
        catalogue: Fraction of catalogue objects in the draws.
        catalogue_replicas: Number of scans per catalogue object.
        furniture_others: Number of procedural objects of each other kind.
        other_weight: Weight of other objects in the draws, in units of a class of the same source.
        draws: Objects per epoch; None means the number of objects.
        hide_visibility: Fraction of the scans with free cells marked unknown.
        hide_scale: Fraction of the scans with unknown size.
        gradient_norm: Gradients are clipped to this norm.
        replicas: Number of augmented variants per object.
        validation: Hold objects back; 100 or more of them select the stored epoch. Otherwise the
            last epoch is stored.
        validation_salt: Another salt holds back other objects.
        precision: "fp32" or "bf16" (automatic mixed precision).
        seed: Seed of all random generators.
        augmented: Whether objects are augmented; otherwise they are unchanged and have the margin
            of the input specification.
        augmentation: The random changes.
        random_yaw: Whether every variant of an object is rotated about the vertical by a random
            angle, as in the papers of several rivals. No headline number uses it.
    """

    # The default of a new field must be the earlier behaviour, since stored settings may lack it.
    # The same holds for `Augmentation`.
    net: str = "planes"
    epochs: int = 24
    passes: int = 1
    batch_size: int = 32
    learning_rate: float = 2e-3
    warm_up: float = 0.15
    optimizer: Literal["adamw", "sgd"] = "adamw"
    weight_decay: float = 0.05
    label_smoothing: float = 0.1
    averaging: float = 0.998
    mixing: float = 0.5
    balance: float = 1.0
    heading: float = 0.2
    furniture: float = 0.0
    furniture_each: int = 200
    scans: bool = False
    scan: ScanAugmentation = field(default_factory=ScanAugmentation)
    catalogue: float = 0.25
    catalogue_replicas: int = 24
    furniture_others: int = 16
    other_weight: float = 4.0
    draws: int | None = None
    hide_visibility: float = 0.4
    hide_scale: float = 0.25
    gradient_norm: float = 5.0
    replicas: int = 24
    validation: bool = True
    validation_salt: str = ""
    precision: Literal["fp32", "bf16"] = "fp32"
    seed: int = 0
    augmented: bool = True
    augmentation: Augmentation = field(default_factory=Augmentation)
    random_yaw: bool = False

    def __post_init__(self) -> None:
        for name in ("epochs", "passes", "batch_size", "replicas", "catalogue_replicas"):
            if getattr(self, name) < 1:
                raise CircumspectError(f"{name} must be at least 1, not {getattr(self, name)}")
        if self.random_yaw and self.replicas == 1:
            raise InputError(
                "--random-yaw turns each variant of an object by one angle: give --replicas 2 or "
                "more, not 1"
            )
        if not 0 <= self.seed < 2**32:
            raise CircumspectError(f"the seed must lie in 0 … 2³² - 1, not {self.seed}")
        for name in ("learning_rate", "gradient_norm"):
            if not 0 < getattr(self, name) < math.inf:
                raise CircumspectError(f"{name} must be positive, not {getattr(self, name)}")
        for name in (
            "averaging", "label_smoothing", "mixing", "balance", "heading", "furniture", "warm_up",
            "catalogue", "hide_visibility", "hide_scale",
        ):  # fmt: skip
            if not 0 <= getattr(self, name) <= 1:
                raise CircumspectError(f"{name} must lie in 0 … 1, not {getattr(self, name)}")
        if self.scans and self.catalogue + self.furniture > 1:
            raise CircumspectError("catalogue and furniture are shares; together at most 1")

    @classmethod
    def of_net(cls, spec: NetSpec, changes: TrainingChanges | None = None) -> TrainingSettings:
        """The settings for a network, with some changes.

        Args:
            spec: The network; the specification of a plug-in may contain unknown settings.
            changes: The requested changes; None means none.

        Raises:
            PluginError: The network requests an unknown setting, or a value of a wrong type.
            InputError: Augmentation is requested for a network that is trained without it.
            CircumspectError: A value is out of range.
        """
        known = {one.name for one in fields(cls)} - {"net"}
        if strange := sorted(set(spec.training) - known):
            raise PluginError(
                f"network '{spec.name}': no training setting {strange[0]!r}; known: "
                f"{', '.join(sorted(known))}"
            )
        given: dict[str, Any] = {}
        if changes is not None:
            given = {**changes.of_run(), "augmentation": Augmentation(**changes.of_objects())}
        try:
            settings = cls(**{**spec.training, **given, "net": spec.name})
        except TypeError as error:
            raise PluginError(
                f"network '{spec.name}': a training setting is of a wrong type ({error})"
            ) from error
        if changes is not None and not settings.augmented and (idle := changes.of_objects()):
            flags = ", ".join(f"--{name}" for name in idle)
            raise InputError(f"{spec.name} is shown objects as they are; leave out {flags}")
        return settings

    def changes(self, margin: float) -> Augmentation:
        """The random changes for a network with a given margin."""
        return self.augmentation if self.augmented else Augmentation.none(margin)

    def require_margin(self, margin: float) -> None:
        """Check that the training grids are as large as the margin requires.

        Raises:
            InputError: The random changes do not include that size.
        """
        least, most = self.changes(margin).scale
        if not least <= margin <= most:
            raise InputError(
                f"the input specification's margin {margin:g} is outside the sizes in training: "
                f"augmentation.scale is {least:g} … {most:g}; change one of them"
            )

    @property
    def max_replicas(self) -> int:
        """Number of variants in memory; sources with fewer repeat theirs equally often."""
        if not self.scans:
            return self.replicas
        return math.lcm(self.replicas, self.catalogue_replicas)

    def to_dict(self) -> dict[str, Any]:
        """The settings as JSON types."""
        return asdict(self)
