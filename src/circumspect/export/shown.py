"""What a network is shown: inputs, and the contexts beside them where it takes any."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Shown:
    """Inputs of n objects, one view each.

    Attributes:
        inputs: (n, *input_shape).
        contexts: (n, 6) float32, or None.
    """

    inputs: NDArray[Any]
    contexts: NDArray[np.float32] | None = None

    @property
    def arrays(self) -> tuple[NDArray[Any], ...]:
        """In the order of the network's inputs."""
        return (self.inputs,) if self.contexts is None else (self.inputs, self.contexts)

    def every_second(self, first: int) -> Shown:
        """Half of the objects, from the first or the second on."""
        contexts = None if self.contexts is None else self.contexts[first::2]
        return Shown(self.inputs[first::2], contexts)
