"""Every command with an input so small that it ends in seconds.

The list of commands is the program's own, so that a test of all of them forgets none.
"""

from __future__ import annotations

import contextlib
import io
import shutil
import sys
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np

SCAN = ("--frames", "3", "--frame-interval", "2", "--seed", "1", "--start", "0")
TRAINING = ("--net", "planes", "--epochs", "2", "--passes", "1", "--replicas", "1")
CAMERAS = (
    "--cameras", "1", "--size", "800", "600", "--seconds", "0.6", "--rate", "5", "--seed", "1",
)  # fmt: skip
Words = tuple[str, ...]


def command_words(only_json: bool = False) -> Iterator[Words]:
    """The words of all commands, asked of the program: ("classify",), ("locate", "track"), …

    Args:
        only_json: Those with the flag --json alone.
    """
    from circumspect.cli.main import COMMANDS, command

    for name in COMMANDS:
        kind = command(name)
        for word, part in _first_words(_hints(kind).get("what"), kind):
            if not only_json or "json" in _hints(part):
                yield (name,) if word is None else (name, word)


def _hints(kind: Any) -> dict[str, Any]:
    return get_type_hints(kind, include_extras=True)


def _first_words(hint: Any, kind: Any) -> list[tuple[str | None, Any]]:
    """What may stand first behind a command, each with the data class of its flags."""
    if get_origin(hint) is Literal:
        return [(word, kind) for word in get_args(hint)]
    for part in get_args(hint):
        if get_args(part) and get_origin(part) is not None:
            found = _first_words(part, kind)
            if found != [(None, kind)]:
                return found
        named = [
            (entry.name, get_args(choice)[0])
            for choice in get_args(part)
            for entry in getattr(choice, "__metadata__", ())
            if hasattr(entry, "name")
        ]
        if named:
            return named
    return [(None, kind)]


class TinyInputs:
    """Inputs of commands, each made when it is first asked for.

    Attributes:
        folder: Where they are.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def words(self, command: Words, out: Path) -> Words:
        """A command's words and flags, so that it ends well.

        Args:
            command: Its first words, see `command_words`.
            out: A folder for its results.

        Raises:
            KeyError: No input is defined for that command.
        """
        given = getattr(self, "_".join(("of", *command)), None)
        if given is None:
            raise KeyError(f"{' '.join(command)}: add a method of_{'_'.join(command)}")
        return (*command, *map(str, given(out)))

    @cached_property
    def chair(self) -> Path:
        from circumspect.furniture import make_furniture
        from circumspect.geometry import write_ply

        write_ply(self.folder / "chair.ply", make_furniture("chair", 3).sampled(800, 0))
        return self.folder / "chair.ply"

    @cached_property
    def lamps(self) -> list[Path]:
        from circumspect.furniture.other_things import make_other_thing
        from circumspect.geometry import PointCloud, write_ply

        files = [self.folder / f"lamp{number}.ply" for number in range(6)]
        for number, file in enumerate(files):
            points = make_other_thing("floor_lamp", number).sampled(3000, 0).points_xyz
            side = 1.2 + 0.04 * number
            write_ply(file, PointCloud(points * side / np.ptp(points, axis=0).max()))
        return files

    @cached_property
    def packs(self) -> Path:
        from circumspect.datasets import ObjectSet
        from circumspect.datasets.point_pack import write_point_pack
        from circumspect.furniture import make_furniture

        classes = ("chair", "sofa")
        for split, count in (("train", 16), ("test", 4)):
            labels = np.arange(count) % 2
            made = [make_furniture(classes[k], 50 + i) for i, k in enumerate(labels)]
            points = np.stack([one.sampled(256, 0).points_xyz for one in made])
            names = np.array([f"{split}_{classes[k]}_{i:04d}" for i, k in enumerate(labels)])
            objects = ObjectSet(points.astype(np.float32), labels.astype(np.int64), names, classes)
            write_point_pack(self.folder / "packs" / f"{split}.npz", objects)
        return self.folder / "packs"

    @cached_property
    def crops(self) -> Path:
        from made_crops import write_crops

        return write_crops(self.folder / "crops.npz")

    @cached_property
    def trained(self) -> Path:
        self._run("train", "--data", self.packs, "--out", self.folder / "trained", *TRAINING)
        return self.folder / "trained"

    @cached_property
    def scanned(self) -> Path:
        """The folder of a run; its recording lies beside it."""
        out = self.folder / "scanned"
        self._run("scan", "chair-3", *SCAN, "--out", out, "--record", out.with_suffix(".mcap"))
        return out

    @cached_property
    def images(self) -> Path:
        out = self.folder / "images"
        run = self.folder / "located"
        self._run("locate", "simulate", *CAMERAS, "--images", out, "--out", run)
        return out

    @cached_property
    def calibration(self) -> Path:
        return self.images / "calibration.json"

    @cached_property
    def catalogue(self) -> Path:
        from sh3f_files import write_sh3f

        return write_sh3f(self.folder / "One.sh3f")

    @cached_property
    def camera_file(self) -> Path:
        """As the SDK of RealSense records it."""
        from realsense_files import recorded

        from circumspect.recording import open_recording
        from circumspect.recording.realsense_camera import realsense_sdk

        sdk = realsense_sdk()
        frames = list(open_recording(self.scanned.with_suffix(".mcap")))
        depths = [frame.depth for frame in frames]
        return recorded(self.folder / "seen.db3", sdk, depths, frames[0].camera, interval=1.0)

    @staticmethod
    def _run(*words: object) -> None:
        from circumspect.cli.main import main

        with contextlib.redirect_stdout(io.StringIO()) as printed:
            code = main([str(word) for word in words])
        if code not in (0, 1):
            raise RuntimeError(f"{words}: {code}, {printed.getvalue()}")

    def of_demo(self, out: Path) -> Any:
        return "--object", "chair", "--seed", 1, "--start", 0, "--frames", 3, "--out", out / "run"

    def of_scan(self, out: Path) -> Any:
        return "chair-3", *SCAN, "--out", out / "run", "--record", out / "run.mcap"

    def of_classify(self, out: Path) -> Any:
        return self.chair, "--threads", 1

    def of_explain(self, out: Path) -> Any:
        return self.chair, "--out", out, "--threads", 1

    def of_models(self, out: Path) -> Any:
        return ()

    def of_teach(self, out: Path) -> Any:
        return "lamp", *self.lamps, "--out", out / "lamps.json"

    def of_grid(self, out: Path) -> Any:
        return self.chair, "--out", out / "grid.npz"

    def of_replay(self, out: Path) -> Any:
        return self.scanned.with_suffix(".mcap"), "--out", out / "run"

    def of_watch(self, out: Path) -> Any:
        return "--camera", self.camera_file, "--out", out / "run"

    def of_gather(self, out: Path) -> Any:
        flags = "--train-objects", 1, "--test-objects", 1, "--test-starts", 0, "--frames", 3
        return "--out", out / "set", "--classes", "chair", *flags, "--workers", 1

    def of_view(self, out: Path) -> Any:
        return self.scanned, "--export", out / "run.html"

    @cached_property
    def recording(self) -> Path:
        """A recording of synthetic frames."""
        sys.path.append(str(Path(__file__).parent / "recording"))
        from bag_world import frame

        from circumspect.recording import RunRecorder

        recorder = RunRecorder(self.folder / "frames.mcap", {})
        for number in range(3):
            recorder.frame(frame(number))
        recorder.close()
        return self.folder / "frames.mcap"

    def of_record_info(self, out: Path) -> Any:
        return (self.recording,)

    def of_ros2(self, out: Path) -> Any:
        return "--local", "--depth", "/depth", "--duration", 1

    def of_locate_simulate(self, out: Path) -> Any:
        return *CAMERAS, "--images", out / "images", "--out", out / "run"

    def of_locate_board(self, out: Path) -> Any:
        return "--out", out, "--format", "png", "--dpi", 60

    def of_locate_intrinsics(self, out: Path) -> Any:
        return self.images / "board" / "ceiling_0", "--out", out / "room.json"

    def of_locate_extrinsics(self, out: Path) -> Any:
        flags = "--survey", self.images / "survey.json", "--intrinsics", self.calibration
        return self.images / "floor" / "ceiling_0", *flags, "--out", out / "room.json"

    def of_locate_track(self, out: Path) -> Any:
        flags = "--calibration", self.calibration, "--tag", 0, 0.2, 0.3
        return self.images / "track", *flags, "--out", out / "run"

    def of_train(self, out: Path) -> Any:
        return "--data", self.packs, "--out", out / "run", "--cache", out / "cache", *TRAINING

    def of_evaluate(self, out: Path) -> Any:
        flags = "--split", "test", "--yaw-count", 4, "--threads", 1
        return "--model", self.trained, "--data", self.packs, *flags, "--out", out / "figures"

    def of_calibrate(self, out: Path) -> Any:
        return self.robot_network, out / "robot.onnx", "--data", self.packs, "--scans", 1

    @cached_property
    def robot_network(self) -> Path:
        from circumspect.classification.shipped import model_path

        return Path(shutil.copy(model_path("robot"), self.folder / "robot.onnx"))

    def of_export(self, out: Path) -> Any:
        return self.trained, out / "net.onnx"

    def of_reproduce_table2(self, out: Path) -> Any:
        flags = "--epochs", 1, "--yaw-count", 2
        return "--data", self.packs, "--out", out / "table", "--cache", out / "cache", *flags

    def of_reproduce_rivals(self, out: Path) -> Any:
        return *self.of_reproduce_table2(out), "--nets", "voxnet"

    def of_reproduce_robustness(self, out: Path) -> Any:
        return self.of_reproduce_rivals(out)

    def of_reproduce_unknown(self, out: Path) -> Any:
        return self.of_reproduce_table2(out)

    def of_reproduce_real(self, out: Path) -> Any:
        return "--crops", self.crops, "--out", out / "table", "--cache", out / "cache"

    def of_data_fetch(self, out: Path) -> Any:
        """An existing set is verified and not fetched again."""
        folder = out / "ModelNet10" / "chair" / "test"
        folder.mkdir(parents=True)
        corners = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
        faces = "3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n"
        (folder / "chair_0890.off").write_text(f"OFF\n4 4 0\n{corners}{faces}")
        return "modelnet10", "--out", out

    def of_data_verify(self, out: Path) -> Any:
        return (self.packs,)

    def of_data_import(self, out: Path) -> Any:
        return "sweethome3d", self.catalogue, "--out", out / "pack.npz"

    def of_data_convert(self, out: Path) -> Any:
        return self.packs, "--out", out / "shards", "--replicas", 1, "--workers", 1

    def of_nets(self, out: Path) -> Any:
        return ()

    def of_doctor(self, out: Path) -> Any:
        return ()

    def of_completion(self, out: Path) -> Any:
        return ("bash",)
