"""Browser dashboard for live and finished runs."""

from circumspect.viewer.dashboard import DEFAULT_HOST, DEFAULT_PORT, Dashboard
from circumspect.viewer.live_watch import LiveWatch
from circumspect.viewer.played_run import PlayedRun
from circumspect.viewer.player import Player
from circumspect.viewer.saved_run import SavedRun

__all__ = [
    "DEFAULT_HOST",
    "DEFAULT_PORT",
    "Dashboard",
    "LiveWatch",
    "PlayedRun",
    "Player",
    "SavedRun",
]
