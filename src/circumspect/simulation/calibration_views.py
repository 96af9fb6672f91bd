"""What ceiling cameras see while they are calibrated: a board held up, tags on the floor."""

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
    calibrate_lens,
    calibrate_place,
)
from circumspect.simulation.ceiling_camera import CeilingCamera, Shown
from circumspect.simulation.ceiling_rig import CeilingRig
from circumspect.simulation.plate import Plate

FIRST_TAG = 100
"""Number of the first tag on the floor."""


def board_images(
    camera: CeilingCamera,
    board: CharucoBoard,
    count: int = 24,
    rng: np.random.Generator | int = 0,
) -> list[NDArray[np.uint8]]:
    """Somebody holds the board up to a camera, in every corner of its view.

    Args:
        camera: Which.
        board: Held up.
        count: How many images.
        rng: Source of the poses.
    """
    rng = np.random.default_rng(rng)
    plate = Plate.printed(board.picture(), board.width, board.height)
    images = []
    for number in range(count):
        far = board.width * float(rng.uniform(0.95, 1.9))
        w, h = camera.camera.lens.size
        # The middle goes round the image so that every part of it gets its share.
        u, v = (0.5 + 0.36 * np.array(_HALTON[number % len(_HALTON)])) * [w, h]
        ray = camera.camera.lens.rays_xy(np.array([[u, v]]))[0]
        turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi)) * Rotation.from_euler(
            "xy", rng.uniform(-0.6, 0.6, 2)
        )
        # The board's face looks at the camera.
        facing = Rotation.from_euler("x", np.pi) * turn
        held = RigidTransform.from_components(far * np.array([*ray, 1.0]), facing)
        shown = Shown(plate, camera.camera.T_map_camera * held)
        images.append(camera.photograph(float(number), (shown,)).grey)
    return images


_HALTON = tuple(
    (float(2 * (number * 0.618034 % 1) - 1), float(2 * (number * 0.754878 % 1) - 1))
    for number in range(1, 65)
)


def laid_tags(
    low_xy: ArrayLike,
    high_xy: ArrayLike,
    size: float = 0.20,
    spacing: float = 0.75,
    position_sigma: float = 0.001,
    rng: np.random.Generator | int = 0,
) -> tuple[Survey, tuple[Shown, ...]]:
    """Tags on the floor, and where somebody with a tape measure believes them to be.

    Args:
        low_xy: (2,) [m] corner of the floor.
        high_xy: (2,) [m] the opposite one.
        size: Of the tags [m].
        spacing: Between them [m].
        position_sigma: Of the survey along each axis [m].
        rng: Source of the places and of the survey's errors.
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
        shown.append(Shown(Plate.tag(number, size), pose))
        dx, dy = rng.normal(0, position_sigma, 2).tolist()
        believed = yaw + float(rng.normal(0, yaw_sigma))
        tags[number] = SurveyedTag(x + dx, y + dy, 0.0, believed)
    return Survey(size, tags, position_sigma, yaw_sigma), tuple(shown)


def calibrated(
    rig: CeilingRig,
    survey: Survey,
    laid: tuple[Shown, ...],
    board: CharucoBoard | None = None,
    rng: np.random.Generator | int = 0,
) -> Calibration:
    """Calibrate all cameras of a room from images, as one does with real ones.

    Args:
        rig: The cameras.
        survey: Of the tags.
        laid: Those tags.
        board: For the lenses; None takes the true lenses.
        rng: Source of the board's poses.

    Raises:
        InputError: A camera sees too little of them.
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
        seen = detector.detect(camera.photograph(0.0, laid).grey)
        place = calibrate_place(name, lens, [seen], survey)
        calibration = calibration.with_lens(name, lens, rms).with_place(place.camera)
    return calibration


def knocked(camera: FixedCamera, T_camera_knocked: RigidTransform) -> FixedCamera:
    """A camera that somebody moved without telling.

    Args:
        camera: As it hung.
        T_camera_knocked: Where it hangs now.
    """
    T_map_camera = camera.T_map_camera * T_camera_knocked
    return FixedCamera(camera.name, camera.lens, T_map_camera, camera.covariance, camera.rms_px)
