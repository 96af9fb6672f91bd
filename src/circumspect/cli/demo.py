"""`circumspect demo`."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circumspect.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from circumspect.pipeline import RecognitionPipeline
    from circumspect.simulation import Orbit, SimulatedCamera


@dataclass(frozen=True)
class Demo:
    """A simulated RGB-D camera circles a piece of furniture and names it.

    $ circumspect demo
    $ circumspect demo --object chair --start 135
    $ circumspect demo --seed 7 --frames 60 --out runs/seven
    """

    object: str | None = None
    """bathtub, bed, chair, desk, dresser, monitor, night_stand, sofa, table or toilet; without it
    one is drawn."""
    start: float | None = None
    """Azimuth of the first frame [degrees], counter-clockwise seen from above; without it drawn."""
    seed: int | None = None
    """The same seed gives the same object, start and noise; without it a new one is drawn."""
    frames: int = 36
    """Frames on the way once round the object."""
    out: Path | None = None
    """Folder of the run; runs/demo-DATE-TIME by default."""
    weights: Path | None = None
    """A classifier of your own, made by `circumspect export`; without it the shipped one."""
    json: bool = False
    """One JSON line on standard output and nothing else there."""

    def run(self) -> int:
        """Circle, model, name, save."""
        from circumspect.cli.run_screen import RunScreen, new_run_folder, tell_result
        from circumspect.pipeline import RunFolder

        config, camera, pipeline = self._prepared()
        folder = RunFolder(self.out or new_run_folder("demo"), config)
        with RunScreen("circling an object", self.frames) as screen:
            pipeline.observers = (screen, folder)
            try:
                result = pipeline.run(camera.frames(self.frames))
            except KeyboardInterrupt:
                screen.say(f"what was gathered so far is in {folder.path}")
                raise
        head = {key: config[key] for key in ("object", "true_label", "start_deg", "seed")}
        tell_result(result, folder, self.json, head)
        return 0

    def _prepared(self) -> tuple[dict[str, Any], SimulatedCamera, RecognitionPipeline]:
        """The run's config, the camera in its scene, and the pipeline."""
        import numpy as np

        from circumspect.classification import Classifier
        from circumspect.furniture import make_furniture
        from circumspect.geometry import PinholeCamera
        from circumspect.mapping import KnownPoses
        from circumspect.pipeline import RecognitionPipeline
        from circumspect.sensing import DepthNoise, GroundSegmentation
        from circumspect.simulation import Orbit, Scene, SimulatedCamera

        if self.frames < 1:
            raise InputError(f"--frames {self.frames}: at least one frame is needed")
        seed = self.seed
        if seed is None:
            seed = int(np.random.default_rng().integers(2**31))
        if seed < 0:
            raise InputError(f"--seed {seed}: give a whole number of at least 0")
        rng = np.random.default_rng(seed)
        # All chance is drawn in any case, so that a given flag does not change the others.
        category, start_deg = self._chosen(rng)
        variant = int(rng.integers(2**31))
        classifier = Classifier.load(self.weights)
        mesh = make_furniture(category, variant)
        intrinsics, noise, segmentation = PinholeCamera.xtion(), DepthNoise(), GroundSegmentation()
        orbit = Orbit.around(mesh, intrinsics, start=float(np.radians(start_deg)), noise=noise)
        camera = SimulatedCamera(
            Scene.with_object(mesh), orbit.stations(self.frames).__next__, intrinsics, noise, rng
        )
        pipeline = RecognitionPipeline(segmentation, KnownPoses(), classifier)
        config = _config(category, variant, seed, start_deg, self.frames, orbit, pipeline)
        return config, camera, pipeline

    def _chosen(self, rng: np.random.Generator) -> tuple[str, float]:
        import numpy as np

        from circumspect.furniture import CATEGORIES

        category, start_deg = str(rng.choice(CATEGORIES)), float(np.round(rng.uniform(0, 360), 1))
        if self.object is not None:
            if self.object not in CATEGORIES:
                raise InputError(f"no object {self.object!r}; known: {', '.join(CATEGORIES)}")
            category = self.object
        if self.start is not None:
            if not np.isfinite(self.start):
                raise InputError(f"--start {self.start}: give degrees")
            start_deg = self.start
        return category, start_deg


def _config(
    category: str,
    variant: int,
    seed: int,
    start_deg: float,
    frames: int,
    orbit: Orbit,
    pipeline: RecognitionPipeline,
) -> dict[str, Any]:
    from circumspect import __version__

    return {
        "command": "demo",
        "version": __version__,
        "object": f"{category}-{variant}",
        "true_label": category,
        "truth": category,
        "seed": seed,
        "start_deg": start_deg,
        "frames": frames,
        "orbit": asdict(orbit),
        "segmentation": asdict(pipeline.segmentation),  # type: ignore[call-overload]
        "model": asdict(pipeline.model.settings),
        "grid": pipeline.classifier.recipe.to_dict(),
    }
