"""A simulated robot scans a chair; its frames are registered to the scene, wheels as the prior.

python examples/04_scan_with_a_robot.py [FRAMES]    # needs: pip install "circumspect[sim]"
"""

import sys

import circumspect as cs


def main(arguments: list[str]) -> None:
    """Drive round it, and compare the path with the true one."""
    frames = int(arguments[0]) if arguments else 400
    noise, place = cs.DepthNoise(), cs.room(cs.make_furniture("chair", 3), seed=7)
    # 5 % of what the wheels turn is lost; the witness alone knows where the robot really is.
    slipping = cs.RobotSettings(slip=0.05)
    robot = cs.GroundTruthRecorder(
        cs.SimulatedRobot(place.scene, place.start(40.0), place.mount, slipping, noise=noise)
    )
    segmentation = cs.GroundSegmentation(noise=noise)
    poses = cs.Tracker(settings=cs.TrackingSettings.for_noise(noise))
    pipeline = cs.RecognitionPipeline(segmentation, poses, cs.Classifier.load())
    settings = cs.ScanSettings(speed=0.2, frame_interval=0.5, max_frames=frames)
    scan = cs.ObjectScan(robot, pipeline, cs.SurfaceNormalPlanner(), settings)

    result = scan.run()
    print(f"the end: {scan.ended}; {scan.driven_m:.1f} m driven, {len(result.steps)} frames")
    if (path := cs.camera_path(result)) is not None:
        error = cs.absolute_trajectory_error(path, robot.trajectory, cs.Alignment.FIRST_POSE)
        print(f"path known within {1e3 * error.rmse_m:.1f} mm")
    if result.prediction is not None:
        print(f"it is named {result.prediction.label}, {result.prediction.probability:.2f}")


if __name__ == "__main__":
    main(sys.argv[1:])
