"""A simulated ceiling camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import RigidTransform

from circumspect.errors import InputError
from circumspect.localization import CeilingImage, FixedCamera, LensCamera
from circumspect.simulation.plate import Plate
from circumspect.simulation.ray_caster import RayCaster

RAYS_PER_PIXEL = 16
"""Rays per pixel on plates. They are in different rows and columns of 16 x 16 cells of the pixel,
so that axis-aligned edges are accurate to 1/32 px."""
NOISE_OFFSETS = 1 << 16
"""Number of offsets into the precomputed noise."""
HALF = np.float32(0.5)
MARGIN_PX = 6
"""Margin of a redrawn plate, as wide as the blur [px]."""


@dataclass(frozen=True)
class CeilingOptics:
    """Imperfections of an image.

    Attributes:
        blur: Standard deviation of the lens's blur [px].
        noise: Standard deviation of a pixel's noise in grey levels.
        gradient: Relative falloff of the light from the brightest to the darkest corner.
        vignetting: Relative darkening of the corners.
        exposure: Exposure time, in which moving plates are blurred [s].
        gain: Grey level of a perfect reflector in the brightest light.

    Raises:
        InputError: A value is invalid.
    """

    blur: float = 0.7
    noise: float = 2.0
    gradient: float = 0.35
    vignetting: float = 0.25
    exposure: float = 0.008
    gain: float = 250.0

    def __post_init__(self) -> None:
        shares = self.gradient, self.vignetting
        if not (0 <= self.blur <= 5 and 0 <= self.noise <= 100 and 0 < self.gain <= 1000):
            raise InputError(
                f"invalid blur ({self.blur} px), noise ({self.noise}) or gain ({self.gain})"
            )
        if not all(0 <= fraction < 1 for fraction in shares) or not 0 <= self.exposure < 1:
            raise InputError(
                f"gradient, vignetting and exposure must be from 0 to below 1, not {shares}"
            )


@dataclass(frozen=True, eq=False)
class PlacedPlate:
    """A plate with its pose.

    Attributes:
        plate: The plate.
        T_map_plate: Pose at the middle of the exposure.
        T_map_plates: Poses during the exposure; empty if the plate does not move.
    """

    plate: Plate
    T_map_plate: RigidTransform
    T_map_plates: tuple[RigidTransform, ...] = ()

    @property
    def poses(self) -> tuple[RigidTransform, ...]:
        """The poses over which the image is averaged."""
        return self.T_map_plates or (self.T_map_plate,)


class CeilingCamera:
    """Renders grey images of a room with plates.

    The static scene, light and blur are rendered once. Plates are drawn into each image with 16
    rays per pixel; nearer parts of the scene occlude them.
    """

    def __init__(
        self,
        camera: FixedCamera,
        caster: RayCaster,
        optics: CeilingOptics | None = None,
        rng: np.random.Generator | int = 0,
    ) -> None:
        """Render the static scene.

        Args:
            camera: True pose and lens.
            caster: Ray caster of the scene; surfaces named "floor" get a texture.
            optics: Blur, noise and light.
            rng: Source of texture and noise.
        """
        self.camera = camera
        self.optics = optics or CeilingOptics()
        self._rng = np.random.default_rng(rng)
        w, h = camera.lens.size
        self._rays = _ray_map(camera.lens)
        self._T_camera_map = camera.T_map_camera.inv()
        self._gain, self._depth, scene = self._render_scene(caster)
        self._static_light = scene * self._gain
        self._background = _blurred(self._static_light, self.optics.blur)
        # Drawing noise would dominate the time; each image uses another part of a precomputed band.
        noise = self._rng.standard_normal(w * h + NOISE_OFFSETS, dtype=np.float32)
        self._noise = np.float32(self.optics.noise) * noise + np.float32(0.5)

    def photograph(self, stamp: float, shown: Sequence[PlacedPlate] = ()) -> CeilingImage:
        """Take an image.

        Args:
            stamp: Time of the middle of the exposure [s].
            shown: Plates; later ones occlude earlier ones.
        """
        light = self._background
        boxes = [self._box(one) for one in shown]
        if found := [box for box in boxes if box is not None]:
            light = light.copy()
            whole = _joined(found)
            patch = self._static_light[whole].copy()
            for one, box in zip(shown, boxes, strict=True):
                if box is not None:
                    self._draw(one, box, patch[_within(box, whole)])
            inner = _without_margin(whole, light.shape)
            light[inner] = _blurred(patch, self.optics.blur)[_within(inner, whole)]
        start = int(self._rng.integers(NOISE_OFFSETS))
        noisy = light + self._noise[start : start + light.size].reshape(light.shape)
        return CeilingImage(self.camera.name, stamp, np.clip(noisy, 0, 255, noisy).astype(np.uint8))

    def is_visible(self, points_xyz: NDArray[np.float64], edge: float = 3.0) -> bool:
        """Whether all points are in the image and not occluded by the scene; for measurements.

        Args:
            points_xyz: (n, 3) [m] map frame.
            edge: Minimum distance from the edge of the image [px].
        """
        pixels = self.camera.project(points_xyz)
        w, h = self.camera.lens.size
        if not ((pixels > edge) & (pixels < np.array([w, h]) - 1 - edge)).all():
            return False
        u, v = np.rint(pixels).astype(int).T
        depth = self.camera.seen_from_camera(points_xyz)[:, 2]
        return not (self._depth[v, u] < depth - 1e-3).any()

    def _render_scene(
        self, caster: RayCaster
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
        """Gain, depth and reflectance of the scene, each (height, width)."""
        flat = self._rays[1:-1, 1:-1]
        h, w = flat.shape[:2]
        optical = np.concatenate([flat, np.ones((h, w, 1), np.float32)], axis=2)
        view = caster.cast(optical, self.camera.T_map_camera)
        palette = np.array(
            [float(np.mean(s.colour)) for s in caster.scene.surfaces] + [0.0], np.float32
        )
        scene = palette[view.surface] * (0.4 + 0.6 * np.cos(view.incidence))
        R = self.camera.T_map_camera.rotation.as_matrix().astype(np.float32)
        places = (optical @ R.T) * view.depth[..., None]
        places += self.camera.position_xyz.astype(np.float32)
        names = np.array([s.name == "floor" for s in caster.scene.surfaces] + [False])
        scene *= np.where(names[view.surface], _floor_texture(places[..., :2]), 1)
        # Light falls off across the room and towards the image corners.
        heading = float(self._rng.uniform(0, 2 * np.pi))
        across = np.linspace(-0.5, 0.5, w, dtype=np.float32) * np.float32(np.cos(heading))
        along = np.linspace(-0.5, 0.5, h, dtype=np.float32) * np.float32(np.sin(heading))
        ramp = across + along[:, None]
        ramp = (ramp - ramp.min()) / max(float(np.ptp(ramp)), 1e-6)
        r2 = (flat**2).sum(axis=2)
        gain = (1 - self.optics.gradient * ramp) * (1 - self.optics.vignetting * r2 / r2.max())
        return (gain * self.optics.gain).astype(np.float32), view.depth, scene.astype(np.float32)

    def _box(self, shown: PlacedPlate) -> tuple[slice, slice] | None:
        """Rows and columns that show a plate, with a margin; None if it is not in the image."""
        points = np.concatenate([T.apply(shown.plate.outline_xyz) for T in shown.poses])
        pixels = self.camera.project(points)
        if not np.isfinite(pixels).all():
            pixels = pixels[np.isfinite(pixels).all(axis=1)]
            if len(pixels) == 0:
                return None
        w, h = self.camera.lens.size
        low = np.floor(pixels.min(axis=0)).astype(int) - 2 * MARGIN_PX
        high = np.ceil(pixels.max(axis=0)).astype(int) + 2 * MARGIN_PX + 1
        (left, top), (right, bottom) = np.maximum(low, 0), np.minimum(high, [w, h])
        return None if right <= left or bottom <= top else (slice(top, bottom), slice(left, right))

    def _draw(
        self, shown: PlacedPlate, box: tuple[slice, slice], light: NDArray[np.float32]
    ) -> None:
        """Draw one plate over the light of a box of pixels, before the blur."""
        rays = self._rays[box[0].start : box[0].stop + 2, box[1].start : box[1].stop + 2]
        middle = rays[1:-1, 1:-1]
        by_u = (rays[1:-1, 2:] - rays[1:-1, :-2]) * HALF
        by_v = (rays[2:, 1:-1] - rays[:-2, 1:-1]) * HALF
        # The depth of the scene is NaN where no surface is hit.
        free = np.where(np.isnan(self._depth[box]), np.float32(np.inf), self._depth[box])
        plate = shown.plate
        picture = np.pad(plate.reflectance, 1, constant_values=np.nan)
        maps = [self._to_picture(plate, T) for T in shown.poses]
        fraction, seen_light = np.zeros(light.shape, np.float32), np.zeros(light.shape, np.float32)
        offsets = _offsets()[:: RAYS_PER_PIXEL // plate.rays]
        passes = max(len(offsets), len(maps))
        # The rays of a pixel are distributed over the poses of the exposure.
        for number in range(passes):
            du, dv = offsets[number % len(offsets)]
            xy = (middle + du * by_u + dv * by_v).astype(np.float32, copy=False)
            found = _reflectance_at(picture, maps[number % len(maps)], xy, free)
            seen = ~np.isnan(found)
            fraction += seen
            seen_light += np.where(seen, found, 0)
        light += (seen_light * self._gain[box] - fraction * light) / passes

    def _to_picture(self, plate: Plate, T_map_plate: RigidTransform) -> NDArray[np.float32]:
        """(3, 3) homography from rays (x, y, 1) to (column, row, 1) / depth in the padded picture.

        Points of the plate are T (x, y, 0, 1); the inverse maps rays to the plate.
        """
        T_camera_plate = (self._T_camera_map * T_map_plate).as_matrix()
        rows, columns = plate.reflectance.shape
        scale = np.array(
            [
                [columns / plate.width, 0, columns / 2 + 1],
                [0, -rows / plate.height, rows / 2 + 1],
                [0, 0, 1],
            ]
        )
        return (scale @ np.linalg.inv(T_camera_plate[:3, [0, 1, 3]])).astype(np.float32)


def _ray_map(lens: LensCamera) -> NDArray[np.float32]:
    """(height + 2, width + 2, 2) rays of all pixels and of a border of one pixel.

    The lens is inverted at every eighth pixel; bicubic splines between them have errors below a
    thousandth of a pixel.
    """
    from scipy.interpolate import RectBivariateSpline

    w, h = lens.size
    u, v = (np.linspace(-1.0, side, max(side // 8, 4)) for side in (w, h))
    grid = np.stack(np.meshgrid(u, v), axis=-1)
    rays = lens.rays_xy(grid.reshape(-1, 2)).reshape(grid.shape)
    pixels = np.arange(-1.0, h + 1), np.arange(-1.0, w + 1)
    maps = [RectBivariateSpline(v, u, rays[..., axis])(*pixels) for axis in (0, 1)]
    return np.stack(maps, axis=-1).astype(np.float32)


def _reflectance_at(
    picture: NDArray[np.float32],
    H: NDArray[np.float32],
    xy: NDArray[np.float32],
    free: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Reflectance of a plate at rays; NaN where they miss it or the scene occludes it."""
    x, y = xy[..., 0], xy[..., 1]
    nearness = H[2, 0] * x + H[2, 1] * y + H[2, 2]
    depth = 1 / nearness
    rows, columns = picture.shape
    column = np.clip((H[0, 0] * x + H[0, 1] * y + H[0, 2]) * depth, 0, columns - 1)
    row = np.clip((H[1, 0] * x + H[1, 1] * y + H[1, 2]) * depth, 0, rows - 1)
    found = picture[row.astype(np.int32), column.astype(np.int32)]
    found[(nearness <= 0) | (free < depth - 1e-3)] = np.nan
    return found


def _offsets() -> list[tuple[np.float32, np.float32]]:
    """Offsets of the rays in a pixel [px]."""
    order = [0, 7, 14, 5, 12, 3, 10, 1, 8, 15, 6, 13, 4, 11, 2, 9]
    places = (
        np.arange(RAYS_PER_PIXEL, dtype=np.float32) + np.float32(0.5)
    ) / RAYS_PER_PIXEL - np.float32(0.5)
    return [(places[i], places[j]) for i, j in enumerate(order)]


def _floor_texture(places_xy: NDArray[np.float32]) -> NDArray[np.float32]:
    """Relative brightness of floor tiles of half a metre with joints; about 1."""
    x, y = places_xy[..., 0], places_xy[..., 1]
    with np.errstate(invalid="ignore"):
        joint = (np.abs(np.mod(x, 0.5) - 0.25) > 0.246) | (np.abs(np.mod(y, 0.5) - 0.25) > 0.246)
        waves = 0.06 * np.sin(3.1 * x + 1.7 * y) + 0.05 * np.sin(7.3 * y - 2.9 * x + 1)
        grain = 0.04 * np.sin(41 * x) * np.sin(37 * y)
    return np.where(joint, 0.7, 1 + waves + grain).astype(np.float32)


def _blurred(light: NDArray[np.float32], sigma: float) -> NDArray[np.float32]:
    if sigma == 0:
        return light
    from scipy.ndimage import gaussian_filter

    return np.asarray(gaussian_filter(light, sigma, mode="nearest", truncate=3.0), np.float32)


def _joined(boxes: Sequence[tuple[slice, slice]]) -> tuple[slice, slice]:
    """The smallest box that contains all boxes."""
    return (
        slice(min(b[0].start for b in boxes), max(b[0].stop for b in boxes)),
        slice(min(b[1].start for b in boxes), max(b[1].stop for b in boxes)),
    )


def _within(box: tuple[slice, slice], outer: tuple[slice, slice]) -> tuple[slice, slice]:
    """A box relative to the corner of another one."""
    rows, columns = (
        slice(part.start - whole.start, part.stop - whole.start)
        for part, whole in zip(box, outer, strict=True)
    )
    return rows, columns


def _without_margin(box: tuple[slice, slice], shape: tuple[int, ...]) -> tuple[slice, slice]:
    """A box without its margin, except at the image's edges; may be empty."""

    def inner(part: slice, size: int) -> slice:
        start = part.start if part.start == 0 else part.start + MARGIN_PX
        stop = part.stop if part.stop == size else part.stop - MARGIN_PX
        return slice(start, max(start, stop))

    return inner(box[0], shape[0]), inner(box[1], shape[1])
