"""A robot whose frames are recorded."""

from __future__ import annotations

from circumspect.recording.run_recorder import RunRecorder
from circumspect.robot import MobileRobot, WrappedRobot
from circumspect.sensing import RgbdFrame


class RecordingRobot(WrappedRobot):
    """Records each frame that is observed, and hands on what the recording holds."""

    def __init__(self, robot: MobileRobot, recorder: RunRecorder) -> None:
        """Wrap a robot, outside of whatever else wraps it."""
        super().__init__(robot)
        self._recorder = recorder

    def observe(self) -> RgbdFrame:
        """See `MobileRobot.observe`."""
        return self._recorder.frame(self.robot.observe())
