"""Small recordings of each kind, as seeds."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "recording"))


def write_recordings(folder: Path) -> list[Path]:
    """An MCAP file of the project's own writer, of another program, a db3 file and a ROS 1 bag."""
    from bag_world import frame
    from foreign_bags import db3_file, mcap, robots_messages, ros1

    from circumspect.recording import RunRecorder

    own = folder / "own.mcap"
    recorder = RunRecorder(own, {})
    for number in range(4):
        recorder.frame(frame(number))
    recorder.close()
    found = [own]
    for number, write in enumerate((db3_file, mcap, ros1)):
        made = folder / f"made-{number}"
        made.mkdir()
        written = write(made, robots_messages())
        found.append(folder / f"foreign-{number}{written.suffix}")
        shutil.copy(written, found[-1])
        shutil.rmtree(made)
    return found
