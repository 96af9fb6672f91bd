"""Settings of the tracker and its parts."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

from circumspect.motion import MotionSettings
from circumspect.pose_graph import KeyframeSettings
from circumspect.registration import DownsamplingSettings, RegistrationSettings
from circumspect.sensing import DepthNoise


@dataclass(frozen=True)
class TrackingSettings:
    """Settings of the tracker and its parts.

    Attributes:
        scan: Thinning of frames.
        registration: Registration of scans.
        motion: Uncertainty of motions.
        keyframes: Selection of keyframes.
        min_points: Scans with fewer points neither start a map nor become keyframes.
        max_rotation_sigma, max_translation_sigma: Largest standard deviations of a reliable pose
            in the local map [rad], [m].
        max_unverified: A pose is not reliable if the camera is assumed to have moved farther than
            this since the last scan that determined its pose [m].
        max_contradictions: The camera is lost after so many consecutive frames that contradict
            the map.
    """

    scan: DownsamplingSettings = field(default_factory=DownsamplingSettings)
    registration: RegistrationSettings = field(default_factory=RegistrationSettings)
    motion: MotionSettings = field(default_factory=MotionSettings)
    keyframes: KeyframeSettings = field(default_factory=KeyframeSettings)
    min_points: int = 300
    max_rotation_sigma: float = 0.02
    max_translation_sigma: float = 0.05
    max_unverified: float = 0.03
    max_contradictions: int = 3

    @classmethod
    def for_noise(cls, noise: DepthNoise) -> Self:
        """For a camera with this depth noise."""
        return cls(scan=DownsamplingSettings(max_depth=noise.farthest, noise=noise))
