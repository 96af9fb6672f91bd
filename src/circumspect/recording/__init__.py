"""Recorded RGB-D frames."""

from circumspect.recording.seven_scenes import SevenScenesFolder

__all__ = ["SevenScenesFolder"]
