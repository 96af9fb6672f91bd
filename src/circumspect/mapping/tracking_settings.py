"""How a camera is followed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np

from circumspect.mapping.gate import GateSettings
from circumspect.mapping.keyframes import KeyframeSettings
from circumspect.mapping.motion import MotionSettings
from circumspect.mapping.relocalisation import RelocalisationSettings
from circumspect.registration import DownsamplingSettings, RegistrationSettings
from circumspect.sensing import DepthNoise


@dataclass(frozen=True)
class TrackingSettings:
    """How frames are followed.

    Attributes:
        scan: How frames are downsampled.
        registration: How they are fitted.
        motion: What is expected between frames.
        gate: What is believed.
        keyframes: What the scene map is made of.
        relocalisation: How a lost camera is found again.
        certain: Largest standard deviations of a pose to build on [rad, m]; the second is a
            little more than wheels leave along a sofa's back, where nothing else holds the camera.
        keeps_overlap: Share of the last frames' overlap that a frame must have.
        doubt: Standard deviations that a frame which contradicts its pose adds [rad, m].
        lost_after: So many such frames in a row, and the camera is lost.
    """

    scan: DownsamplingSettings = field(default_factory=DownsamplingSettings)
    registration: RegistrationSettings = field(default_factory=RegistrationSettings)
    motion: MotionSettings = field(default_factory=MotionSettings)
    gate: GateSettings = field(default_factory=GateSettings)
    keyframes: KeyframeSettings = field(default_factory=KeyframeSettings)
    relocalisation: RelocalisationSettings = field(default_factory=RelocalisationSettings)
    certain: tuple[float, float] = (0.02, 0.05)
    keeps_overlap: float = 0.6
    doubt: tuple[float, float] = (float(np.radians(1.0)), 0.02)
    lost_after: int = 3

    @classmethod
    def uncalibrated(cls, noise: DepthNoise) -> Self:
        """For a camera of whose depth only the nearer part is true."""
        return cls(scan=DownsamplingSettings(noise=noise))

    @classmethod
    def calibrated(cls, noise: DepthNoise) -> Self:
        """For a camera whose depth is true, but for its noise, as far as it reaches."""
        return cls(scan=DownsamplingSettings(max_depth=noise.farthest, noise=noise))
