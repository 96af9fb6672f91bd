"""Player of a finished run in a dashboard: time bar, play and pause, speed."""

from __future__ import annotations

import threading

import numpy as np

from circumspect.viewer.dashboard import Dashboard
from circumspect.viewer.guarded_server import clipped
from circumspect.viewer.played_run import PlayedRun

SPEEDS = {"2 frames/s": 2.0, "5 frames/s": 5.0, "10 frames/s": 10.0, "20 frames/s": 20.0}
USUAL = "10 frames/s"
PLAY, PAUSE = "Play", "Pause"


class Player:
    """Adds playback controls to a dashboard and moves the time bar in its own thread."""

    def __init__(self, played: PlayedRun, dashboard: Dashboard) -> None:
        """Show the first frame and start playback.

        Args:
            played: A run with at least one frame.
            dashboard: The dashboard.
        """
        self._played, self._dashboard = played, dashboard
        self._closed = threading.Event()
        self._playing, self._at = True, 1
        # Both the player and the user move the bar.
        self._moving = threading.RLock()
        gui = dashboard.server.gui
        dashboard.total = len(played)
        with gui.add_folder("Playback", order=-1.0):
            self.button = gui.add_button(PAUSE)
            self.bar = gui.add_slider("frame", 1, max(2, len(played)), 1, 1)
            self.speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value=USUAL)
        self._listen()
        self.show(0)
        self._thread = threading.Thread(target=self._play, name="player", daemon=True)
        self._thread.start()

    def show(self, frame: int) -> None:
        """Show a frame, numbered from 0 and clipped to the run."""
        number = int(np.clip(frame, 0, len(self._played) - 1))
        self._dashboard.put(lambda: self._played.state_at(number))

    def close(self) -> None:
        """Stop playback."""
        self._closed.set()
        self._thread.join(timeout=1.0)

    def _listen(self) -> None:
        @self.button.on_click
        def _(event: object) -> None:  # noqa: ARG001
            with self._moving:
                if not self._playing and self._at >= len(self._played):
                    self._move(1)
                self._set_playing(not self._playing)

        @self.bar.on_update
        def _(event: object) -> None:  # noqa: ARG001
            with self._moving:
                self._heed_bar()

    def _heed_bar(self) -> bool:
        """Show the frame of a bar that the user moved, and pause; returns whether it was moved."""
        wanted = int(clipped(self.bar.value, 1.0, float(len(self._played))))
        if wanted == self._at:
            return False
        was_playing = self._playing
        self._set_playing(False)
        if was_playing:
            # The player's last moves may still arrive at the browser and overwrite this value. It
            # is sent again; viser sends only changes.
            self._at = self.bar.value = wanted - 1 if wanted > 1 else wanted + 1
        self._at = self.bar.value = wanted
        self.show(wanted - 1)
        return True

    def _move(self, place: int) -> None:
        self._at = self.bar.value = place
        self.show(place - 1)

    def _set_playing(self, playing: bool) -> None:
        self._playing = playing
        self.button.label = PAUSE if playing else PLAY

    def _play(self) -> None:
        while not self._closed.wait(1 / SPEEDS.get(str(self.speed.value), SPEEDS[USUAL])):
            with self._moving:
                if not self._playing or not self._dashboard.watched or self._heed_bar():
                    continue
                if self._at >= len(self._played):
                    self._set_playing(False)
                    continue
                self._move(self._at + 1)
