"""Depth frames with known poses become one model, its grid and its name.

python examples/03_fuse_depth_frames.py    # needs: pip install "circumspect[sim]"
"""

import circumspect as cs
from circumspect.simulation import Orbit, Scene, SimulatedCamera

FRAMES = 12


def main() -> None:
    """Look at a toilet from a circle; every frame carries its pose."""
    toilet = cs.make_furniture("toilet", 2)
    camera = cs.PinholeCamera(320, 240, fx=285.0, fy=285.0, cx=159.5, cy=119.5)
    stations = Orbit.around(toilet, camera).stations(FRAMES)

    # Any camera will do whose frames are `RgbdFrame(depth, camera, stamp, T_map_camera)`.
    scene = Scene.with_object(toilet)
    frames = SimulatedCamera(scene, stations.__next__, camera, cs.DepthNoise(), rng=0).frames(
        FRAMES
    )

    poses, classifier = cs.KnownPoses(), cs.Classifier.load()
    pipeline = cs.RecognitionPipeline(cs.GroundSegmentation(), poses, classifier)
    for frame in frames:
        step = pipeline.step(frame)
        answer = step.outcome
        if step.prediction is not None:
            answer = step.prediction.text
        print(f"{step.index:2}: {step.object_pixels:5} px, {step.coverage:4.0%} coverage, {answer}")

    pipeline.finalise()  # all of the classifier's grids are asked once no more frames come
    print(f"in the end: {pipeline.prediction}")
    pipeline.model.save("toilet.ply")
    if pipeline.grid is not None:
        pipeline.grid.save("toilet.npz")
    print(f"toilet.ply holds {len(pipeline.model.cloud())} points, toilet.npz the grid")


if __name__ == "__main__":
    main()
