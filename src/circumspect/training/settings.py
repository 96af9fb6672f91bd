"""What a training run is made of."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

from circumspect.datasets import Augmentation
from circumspect.datasets.scan_augmentation import ScanAugmentation
from circumspect.errors import CircumspectError, InputError
from circumspect.nets.registry import NetSpec
from circumspect.plugins import PluginError


@dataclass(frozen=True)
class TrainingSettings:
    """All that determines a run; written to its folder.

    Attributes:
        net: Name of the network.
        epochs: How many; after each the held-back objects are named, and progress is saved.
        passes: How often an epoch goes through the set; `passes_for` says how often it should go
            through a small one.
        batch_size: Objects a step, over all processes.
        learning_rate: Its peak; it warms up linearly and decays as a cosine.
        warm_up: Share of the run until the peak.
        optimizer: "adamw", or "sgd" with a momentum of 0.9.
        weight_decay: On weights of two and more dimensions.
        label_smoothing: Share of the target spread over all classes.
        averaging: Decay a step of the averaged weights, which are those kept.
        mixing: Share of the batches in which each grid is blended with another (mixup, Zhang et
            al. 2018); the larger share is drawn from Beta(0.4, 0.4).
        balance: 1 draws all classes equally often, 0 all objects.
        heading: Weight of the loss on the heading, for networks that tell it.
        furniture: Share of the draws that are procedural furniture.
        furniture_each: Pieces made of each category.
        scans: Train on simulated scans, with visibility, size and a class of other things.
        scan: How these scans are made.
        catalogue: Share of the draws that are objects of catalogues.
        catalogue_replicas: Scans made of each of their objects.
        furniture_others: Procedural things made of each other kind.
        other_weight: How often other things are drawn, in units of a class of the same source.
        draws: Objects an epoch; None means as many as there are.
        hide_visibility: Share of the scans whose free cells count as unknown.
        hide_scale: Share of the scans whose size counts as unknown.
        gradient_norm: Longer gradients are shortened to this.
        replicas: Augmented variants made of each object.
        validation: Hold objects back; 100 or more of them choose the epoch that is kept. With
            fewer, and where all objects train, the last one is.
        validation_salt: Another salt holds back other objects.
        precision: "fp32" or "bf16" (automatic mixed precision).
        seed: Of all chance.
        augmented: Objects are changed at random; without it they are shown as they are, with the
            recipe's margin.
        augmentation: The random changes.
        random_yaw: Every variant of an object is turned about the vertical by a random angle, as
            the papers of several rivals do. No headline number comes from such a training.
    """

    # Stored settings that lack a field are taken to have its default: that of a new one must mean
    # what was done before, here and in `Augmentation`.
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
    def of_net(cls, spec: NetSpec, **changes: Any) -> TrainingSettings:
        """As a network is meant to be trained, but for some changes.

        Args:
            spec: The network; of another package, it may ask for what there is not.
            changes: Settings by name.

        Raises:
            PluginError: The network asks for an unknown setting, or for one of a wrong type.
            CircumspectError: A value is out of range.
        """
        known = {one.name for one in fields(cls)} - {"net"}
        if strange := sorted(set(spec.training) - known):
            raise PluginError(
                f"network '{spec.name}': no training setting {strange[0]!r}; known: "
                f"{', '.join(sorted(known))}"
            )
        try:
            return cls(**{**spec.training, **changes, "net": spec.name})
        except TypeError as error:
            raise PluginError(
                f"network '{spec.name}': a training setting is of a wrong type ({error})"
            ) from error

    def changes(self, margin: float) -> Augmentation:
        """The random changes that are made for a network that will be asked with a margin."""
        return self.augmentation if self.augmented else Augmentation.none(margin)

    def require_margin(self, margin: float) -> None:
        """Check that a network is trained on grids as large as those that it will be asked with.

        Raises:
            InputError: The random changes make none of that size.
        """
        least, most = self.changes(margin).scale
        if not least <= margin <= most:
            raise InputError(
                f"a recipe with margin {margin:g} asks about sizes that are not trained on: "
                f"augmentation.scale is {least:g} … {most:g}; change one of them"
            )

    @property
    def most_replicas(self) -> int:
        """Variants that are drawn from; sources with fewer show each as often as any other."""
        if not self.scans:
            return self.replicas
        return math.lcm(self.replicas, self.catalogue_replicas)

    def to_dict(self) -> dict[str, Any]:
        """The settings as JSON types."""
        return asdict(self)
