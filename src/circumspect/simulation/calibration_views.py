"""Simulated images for calibration: a board held up to a camera, tags on the floor."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.localization import (
    Calibration,
    CharucoBoard,
    FixedCamera,
    Survey,
    SurveyedTag,
    TagDetector,
    calibrate_extrinsics,
    calibrate_lens,
)
from circumspect.simulation.ceiling_camera import CeilingCamera, PlacedPlate
from circumspect.simulation.ceiling_rig import CeilingRig
from circumspect.simulation.plate import Plate

FIRST_TAG = 100
"""Number of the first floor tag."""


def board_images(
    camera: CeilingCamera,
    board: CharucoBoard,
    count: int = 24,
    rng: np.random.Generator | int = 0,
) -> list[NDArray[np.uint8]]:
    """Simulate images of a board that is held up to a camera in all parts of its view.

    Args:
        camera: The camera.
        board: The board.
        count: Number of images.
        rng: Source of the poses.
    """
    rng = np.random.default_rng(rng)
    plate = Plate.printed(board.picture(), board.width, board.height)
    images = []
    for number in range(count):
        far = board.width * float(rng.uniform(0.95, 1.9))
        w, h = camera.camera.lens.size
        # The centre of the board moves over the whole image.
        u, v = (0.5 + 0.36 * np.array(_HALTON[number % len(_HALTON)])) * [w, h]
        ray = camera.camera.lens.rays_xy(np.array([[u, v]]))[0]
        turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi)) * Rotation.from_euler(
            "xy", rng.uniform(-0.6, 0.6, 2)
        )
        # The board faces the camera.
        facing = Rotation.from_euler("x", np.pi) * turn
        held = RigidTransform.from_components(far * np.array([*ray, 1.0]), facing)
        shown = PlacedPlate(plate, camera.camera.T_map_camera * held)
        images.append(camera.photograph(float(number), (shown,)).grey)
    return images


_HALTON = tuple(
    (float(2 * (number * 0.618034 % 1) - 1), float(2 * (number * 0.754878 % 1) - 1))
    for number in range(1, 65)
)


def surveyed_tags(
    low_xy: ArrayLike,
    high_xy: ArrayLike,
    size: float = 0.20,
    spacing: float = 0.75,
    position_sigma: float = 0.001,
    rng: np.random.Generator | int = 0,
) -> tuple[Survey, tuple[PlacedPlate, ...]]:
    """Place tags on the floor and survey them with measurement errors.

    Args:
        low_xy: (2,) corner of the floor [m].
        high_xy: (2,) opposite corner [m].
        size: Size of the tags [m].
        spacing: Spacing of the tags [m].
        position_sigma: Standard deviation of the survey along each axis [m].
        rng: Source of positions and survey errors.
    """
    rng = np.random.default_rng(rng)
    low, high = np.asarray(low_xy, float), np.asarray(high_xy, float)
    counts = np.maximum(np.round((high - low) / spacing).astype(int) + 1, 2)
    places = np.stack(
        np.meshgrid(*(np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True))), -1
    ).reshape(-1, 2)
    tags: dict[int, SurveyedTag] = {}
    shown = []
    yaw_sigma = float(np.radians(0.5))
    for number, (x, y) in enumerate(places.tolist(), start=FIRST_TAG):
        yaw = float(rng.uniform(-np.pi, np.pi))
        pose = RigidTransform.from_components([x, y, 0.0], Rotation.from_euler("z", yaw))
        shown.append(PlacedPlate(Plate.tag(number, size), pose))
        dx, dy = rng.normal(0, position_sigma, 2).tolist()
        believed = yaw + float(rng.normal(0, yaw_sigma))
        tags[number] = SurveyedTag(x + dx, y + dy, 0.0, believed)
    return Survey(size, tags, position_sigma, yaw_sigma), tuple(shown)


def calibrated(
    rig: CeilingRig,
    survey: Survey,
    tags: tuple[PlacedPlate, ...],
    board: CharucoBoard | None = None,
    rng: np.random.Generator | int = 0,
) -> Calibration:
    """Calibrate all cameras of a room from simulated images.

    Args:
        rig: The cameras.
        survey: Survey of the tags.
        tags: The tags.
        board: Board for the lenses; None to use the true lenses.
        rng: Source of the board's poses.

    Raises:
        InputError: A camera does not see enough tags or corners of the board.
        MissingExtraError: OpenCV or pupil-apriltags is not installed.
    """
    rng = np.random.default_rng(rng)
    detector = TagDetector(1.0)
    calibration = Calibration({}, {}, (), rig.mount)
    for camera in rig.cameras:
        name, lens, rms = camera.camera.name, camera.camera.lens, 0.0
        if board is not None:
            found = calibrate_lens(board_images(camera, board, rng=rng), board)
            lens, rms = found.lens, found.rms_px
        seen = detector.detect(camera.photograph(0.0, tags).grey)
        place = calibrate_extrinsics(name, lens, [seen], survey)
        calibration = calibration.with_lens(name, lens, rms).with_place(place.camera)
    return calibration


def displaced(camera: FixedCamera, T_camera_displaced: RigidTransform) -> FixedCamera:
    """A camera that was moved after calibration.

    Args:
        camera: The camera before.
        T_camera_displaced: Its new pose, relative to the old one.
    """
    T_map_camera = camera.T_map_camera * T_camera_displaced
    return FixedCamera(camera.name, camera.lens, T_map_camera, camera.covariance, camera.rms_px)
