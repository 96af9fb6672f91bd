"""Calibration of the extrinsics from tags at surveyed positions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.localization.fixed_camera import FixedCamera
from circumspect.localization.lens_camera import LensCamera
from circumspect.localization.opencv import opencv
from circumspect.localization.survey import Survey, SurveyedTag
from circumspect.localization.tag_detector import TagDetection
from circumspect.localization.tag_mount import CORNERS
from circumspect.localization.tag_pose import CORNER_SIGMA, corner_slopes

MIN_TAGS = 3
MAX_ITERATIONS, MIN_STEP = 30, 1e-10
"""Limits of the iteration [m], [rad]."""
MAX_RMS_PX = 2.0
"""Maximum reprojection error of a valid calibration [px]."""
MAX_RMS_RATIO, MIN_RMS_PX = 4.0, 0.1
"""A tag is rejected if its reprojection error exceeds this multiple of the median and this value
[px]."""
OUTLIER_SIGMAS = 5.0
"""A tag this many standard deviations from its surveyed position is rejected.

More than half of the tags must be kept."""


@dataclass(frozen=True, eq=False)
class ExtrinsicsCalibration:
    """Pose of a camera and residuals of the survey.

    Attributes:
        camera: The camera with pose and covariance.
        offsets_m: Distance of each tag from its surveyed position [m].
        left_out: Rejected tags, with the reason.
    """

    camera: FixedCamera
    offsets_m: dict[int, float]
    left_out: dict[int, str]


def calibrate_extrinsics(
    name: str,
    lens: LensCamera,
    images: Sequence[Sequence[TagDetection]],
    survey: Survey,
    corner_sigma: float = CORNER_SIGMA,
) -> ExtrinsicsCalibration:
    """Estimate the pose of a camera together with the errors of the survey.

    Minimises the squared reprojection errors over `corner_sigma`² plus the squared offsets of the
    tags from the survey over its variances. The covariance of the pose is its block of the inverse
    of JᵀJ, scaled up if the residuals are larger than expected.

    Args:
        name: Name of the camera.
        lens: Intrinsics.
        images: Detected tags of each image from the same place; their corners are averaged.
        survey: Surveyed tags.
        corner_sigma: Standard deviation of a detected corner along each image axis [px].

    Raises:
        InputError: Too few surveyed tags are visible, or they do not fit.
        MissingExtraError: OpenCV is not installed.
    """
    corners = _averaged(images)
    left_out = {tag: "it is not in the survey" for tag in corners if tag not in survey.tags}
    corners = {tag: uv for tag, uv in corners.items() if tag in survey.tags}
    wanted = len(corners) / 2
    while True:
        _require(name, corners, left_out)
        start = _first(name, lens, corners, survey)
        fit = _fitted(start, corners, survey, corner_sigma)
        wrong = fit.worst_tag(survey)
        if wrong is None or len(corners) <= max(MIN_TAGS, wanted + 1):
            break
        left_out[wrong[0]] = wrong[1]
        del corners[wrong[0]]
    if not fit.rms_px < MAX_RMS_PX or wrong is not None:
        detail = "" if wrong is None else f"; tag {wrong[0]}: {wrong[1]}"
        raise InputError(
            f"camera '{name}': the tags do not fit the survey ({fit.rms_px:.2f} px{detail}); check "
            "size and positions of the tags and the intrinsics"
        )
    camera = FixedCamera(name, lens, fit.T_map_camera, fit.covariance, fit.rms_px)
    return ExtrinsicsCalibration(camera, dict(sorted(fit.offsets.items())), left_out)


@dataclass(frozen=True, eq=False)
class _Fit:
    T_map_camera: RigidTransform
    covariance: NDArray[np.float64]
    tag_rms: dict[int, float]
    offsets: dict[int, float]

    @property
    def rms_px(self) -> float:
        """Root mean square error of all corners [px]."""
        return float(np.sqrt(np.mean(np.square(list(self.tag_rms.values())))))

    def worst_tag(self, survey: Survey) -> tuple[int, str] | None:
        """The tag with the largest error if it is an outlier, with the reason."""
        usual = max(float(np.median(list(self.tag_rms.values()))), MIN_RMS_PX)
        worst = max(self.tag_rms, key=lambda tag: self.tag_rms[tag])
        if self.tag_rms[worst] > MAX_RMS_RATIO * usual:
            return worst, f"its corners are {self.tag_rms[worst]:.2f} px off: partly hidden?"
        worst = max(self.offsets, key=lambda tag: self.offsets[tag])
        if self.offsets[worst] > OUTLIER_SIGMAS * survey.position_sigma:
            apart = 1e3 * self.offsets[worst]
            return worst, f"it lies {apart:.0f} mm from its surveyed position"
        return None


def _averaged(images: Sequence[Sequence[TagDetection]]) -> dict[int, NDArray[np.float64]]:
    seen: dict[int, list[NDArray[np.float64]]] = {}
    for tags in images:
        numbers = [tag.tag_id for tag in tags]
        for tag in tags:
            if numbers.count(tag.tag_id) == 1:
                seen.setdefault(tag.tag_id, []).append(tag.corners_uv)
    return {tag: np.median(uv, axis=0) for tag, uv in sorted(seen.items())}


def _require(name: str, corners: Mapping[int, object], left_out: Mapping[int, str]) -> None:
    if len(corners) < MIN_TAGS:
        detail = "; ".join(f"tag {tag}: {why}" for tag, why in left_out.items())
        raise InputError(
            f"camera '{name}' sees {len(corners)} surveyed tags, at least {MIN_TAGS} are needed"
            + (f" ({detail})" if detail else "")
        )


def _first(
    name: str, lens: LensCamera, corners: Mapping[int, NDArray[np.float64]], survey: Survey
) -> FixedCamera:
    """Initial pose from the survey: corners, or centres of tags without a direction."""
    points, pixels = [], []
    for tag, uv in corners.items():
        place = survey.tags[tag]
        if place.yaw is None:
            points.append([[place.x, place.y, place.z]])
            pixels.append([_middle(uv)])
        else:
            xy = _corners_xy(np.array([[place.x, place.y]]), np.array([place.yaw]), survey.size)
            points.append(np.column_stack([xy[0], np.full(len(CORNERS), place.z)]))
            pixels.append(uv)
    ground, seen = np.concatenate(points), np.concatenate(pixels)
    if np.linalg.matrix_rank((ground - ground.mean(axis=0))[:, :2], tol=1e-3) < 2 or len(seen) < 4:
        raise InputError(
            f"camera '{name}': the tags' centres are collinear or fewer than 4; measure their "
            "directions as well, or add tags"
        )
    cv2 = opencv()
    rays = lens.rays_xy(seen)
    nowhere = InputError(
        f"camera '{name}': no pose explains the tags in the image; check the survey and the "
        "intrinsics"
    )
    try:
        good, turn, shift = cv2.solvePnP(
            ground.reshape(-1, 1, 3), rays.reshape(-1, 1, 2), np.eye(3), None,
            flags=cv2.SOLVEPNP_SQPNP,
        )  # fmt: skip
    except cv2.error as error:  # Impossible sizes or focal lengths.
        raise nowhere from error
    if not good:
        raise nowhere
    T_camera_map = RigidTransform.from_components(shift.ravel(), Rotation.from_rotvec(turn.ravel()))
    return FixedCamera(name, lens, T_camera_map.inv())


def _fitted(
    start: FixedCamera,
    corners: Mapping[int, NDArray[np.float64]],
    survey: Survey,
    corner_sigma: float,
) -> _Fit:
    """Gauss-Newton over the pose and the offsets of all tags."""
    tags = list(corners)
    seen_uv = np.concatenate([corners[tag] for tag in tags])
    floor = _Floor.of(start, corners, survey)
    camera, offsets = start, np.zeros((len(tags), 3))
    residual, J = floor.linear(camera, offsets, seen_uv, corner_sigma)
    for _ in range(MAX_ITERATIONS):
        step = np.linalg.lstsq(J, residual, rcond=None)[0]
        moved = camera.T_map_camera * RigidTransform.from_exp_coords(step[:6])
        camera = FixedCamera(start.name, start.lens, moved)
        offsets = offsets + step[6:].reshape(-1, 3)
        residual, J = floor.linear(camera, offsets, seen_uv, corner_sigma)
        if np.abs(step).max() < MIN_STEP:
            break
    measured = seen_uv.size + 2 * len(tags) + int(np.count_nonzero(floor.yaw_weights))
    excess = max(1.0, float(residual @ residual) / max(measured - J.shape[1], 1))
    covariance = excess * np.linalg.inv(J.T @ J)[:6, :6]
    pixels = residual[: seen_uv.size].reshape(len(tags), -1) * corner_sigma
    rms = np.sqrt(2 * np.mean(pixels**2, axis=1))
    apart = np.linalg.norm(offsets[:, :2], axis=1)
    return _Fit(
        camera.T_map_camera,
        (covariance + covariance.T) / 2,
        dict(zip(tags, map(float, rms), strict=True)),
        dict(zip(tags, map(float, apart), strict=True)),
    )


@dataclass(frozen=True, eq=False)
class _Floor:
    """Arrays of n surveyed tags."""

    survey: Survey
    places_xy: NDArray[np.float64]
    heights: NDArray[np.float64]
    yaws: NDArray[np.float64]
    yaw_weights: NDArray[np.float64]
    """Inverse standard deviation of each direction; 0 if it was not measured."""

    @classmethod
    def of(
        cls, start: FixedCamera, corners: Mapping[int, NDArray[np.float64]], survey: Survey
    ) -> _Floor:
        tags = [survey.tags[tag] for tag in corners]
        return cls(
            survey,
            np.array([[tag.x, tag.y] for tag in tags]),
            np.repeat([tag.z for tag in tags], len(CORNERS)),
            np.array([_yaw(start, uv, survey.tags[tag]) for tag, uv in corners.items()]),
            np.array([tag.yaw is not None for tag in tags]) / survey.yaw_sigma,
        )

    def linear(
        self,
        camera: FixedCamera,
        offsets: NDArray[np.float64],
        seen_uv: NDArray[np.float64],
        corner_sigma: float,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Residuals (measured minus expected, in standard deviations) and Jacobian of the
        expectation.

        Columns are φ and ρ of the camera, then x, y [m] and yaw [rad] of each tag's offset; rows
        are corners, then the survey's places and directions.
        """
        count = len(offsets)
        middles = self.places_xy + offsets[:, :2]
        xy = _corners_xy(middles, self.yaws + offsets[:, 2], self.survey.size)
        ground = np.column_stack([xy.reshape(-1, 2), self.heights])
        points = camera.seen_from_camera(ground)
        expected = camera.lens.project(points)
        if not np.isfinite(expected).all():
            raise InputError(
                f"camera '{camera.name}': the tags do not fit the survey: some would not be "
                "visible; check their numbers and positions"
            )
        around = (xy - middles[:, None]).reshape(-1, 2)
        by_camera, by_tag = corner_slopes(camera, points, around)
        J = np.zeros((seen_uv.size + 3 * count, 6 + 3 * count))
        J[: seen_uv.size, :6] = by_camera.reshape(-1, 6)
        rows = by_tag.reshape(count, 2 * len(CORNERS), 3)
        for tag in range(count):
            height = rows.shape[1]
            J[height * tag : height * (tag + 1), 6 + 3 * tag : 9 + 3 * tag] = rows[tag]
        J[: seen_uv.size] /= corner_sigma
        weights = np.column_stack(
            [np.full((count, 2), 1 / self.survey.position_sigma), self.yaw_weights]
        )
        J[seen_uv.size :, 6:] = np.diag(weights.ravel())
        residual = np.concatenate(
            [(seen_uv - expected).ravel() / corner_sigma, -(offsets * weights).ravel()]
        )
        return residual, J


def _yaw(camera: FixedCamera, uv: NDArray[np.float64], place: SurveyedTag) -> float:
    """The surveyed direction, or that of the tag's lower edge in the image."""
    if place.yaw is not None:
        return place.yaw
    edge = camera.on_plane(uv[:2], place.z)
    along = edge[1] - edge[0]
    return float(np.arctan2(along[1], along[0]))


def _corners_xy(
    places_xy: NDArray[np.float64], yaws: NDArray[np.float64], size: float
) -> NDArray[np.float64]:
    """(n, 4, 2) corners of n tags [m], from positions (n, 2) [m] and yaws (n,) [rad]."""
    c, s = np.cos(yaws), np.sin(yaws)
    turns = np.stack([c, s, -s, c], axis=1).reshape(-1, 2, 2)
    return size * CORNERS @ turns + places_xy[:, None]


def _middle(uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2,) intersection of the diagonals [px]."""
    return TagDetection(0, uv, 0.0, 0).centre_uv
