"""`circumspect replay --viewer`: a recording that is shown and held back in the browser."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from circumspect.cli.dashboard_page import stay
from circumspect.cli.say import say

if TYPE_CHECKING:
    from circumspect.cli.replay import Replay
    from circumspect.recognition import PipelineObserver
    from circumspect.sensing import RgbdFrame
    from circumspect.viewer import Dashboard


class ReplayWatch:
    """Puts the dashboard round one replay."""

    def __init__(self, dashboard: Dashboard) -> None:
        from circumspect.viewer.run_controls import RunControls

        self._dashboard, self._controls = dashboard, RunControls(dashboard)

    def watched(
        self, frames: Iterable[RgbdFrame]
    ) -> tuple[Iterable[RgbdFrame], tuple[PipelineObserver, ...]]:
        """The frames as the onlooker lets them through, and who shows what comes of them."""
        from circumspect.robot import Operator
        from circumspect.viewer import LiveWatch
        from circumspect.viewer.operated_frames import OperatedFrames

        operator = Operator()
        self._controls.take(operator)
        operated = OperatedFrames(frames, operator)
        return operated, (LiveWatch(operated, self._dashboard),)


def watched_replay(replay: Replay) -> int:
    """Replay with the dashboard, which then stays until Ctrl-C.

    Args:
        replay: The command's flags.

    Returns:
        Exit code of the replay.
    """
    from circumspect.classification import Classifier

    with replay.page.opened(Classifier.load(replay.model)) as dashboard:
        code = replay.replay(ReplayWatch(dashboard))
        try:
            # Within: whoever reads the line may press Ctrl-C at once.
            say("the page stays open until Ctrl-C")
            stay()
        except KeyboardInterrupt:
            say("the dashboard is closed")
    return code
