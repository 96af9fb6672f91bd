"""The angular Fourier basis, equations 1 and 2 of the paper."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from circumspect.errors import InputError
from circumspect.grid.cylindrical_grid import AZIMUTH_AXIS, CylindricalGrid
from circumspect.grid.grid import OccupancyGrid


def spectrum_orders(azimuth_cells: int) -> NDArray[np.int64]:
    """All orders m that a number of azimuth cells can resolve.

    Returns:
        (azimuth_cells,) 0, 1, 2, …, then the negative ones up to -1.
    """
    return np.rint(np.fft.fftfreq(azimuth_cells) * azimuth_cells).astype(np.int64)


def angular_spectrum(
    values: OccupancyGrid | ArrayLike, orders: Sequence[int] | None = None
) -> NDArray[np.complex128]:
    """Coefficients a_m of equation 1, J(θ) = Σ_m a_m e^{imθ}, along the azimuth axis.

    θ counts from the first cell. Σ_m |a_m|² is the mean of |J|² over the cells (Parseval).

    Args:
        values: A cylindrical grid, whose occupied cells count 1; or (…, radius, azimuth, height)
            values of the cells of one or many.
        orders: The orders m; None means all, in the order of `spectrum_orders`. Orders that differ
            by the number of cells are the same on a grid.

    Returns:
        (…, radius, order, height).

    Raises:
        InputError: Fewer than three axes, a grid that is not cylindrical, or orders that are not
            whole numbers.
    """
    if isinstance(values, OccupancyGrid):
        if not isinstance(values.grid, CylindricalGrid):
            raise InputError("only a cylindrical grid has an angular spectrum")
        values = values.occupied
    cells = np.asarray(values)
    if cells.ndim < 3:
        raise InputError(f"values must have shape (…, radius, azimuth, height), not {cells.shape}")
    axis = _azimuth_of(cells)
    count = cells.shape[axis]
    if count == 0:
        raise InputError(f"values of shape {cells.shape} have no azimuth cells")
    spectrum = np.fft.fft(cells, axis=axis, norm="forward")
    if orders is None:
        return spectrum
    return np.take(spectrum, _whole(orders) % count, axis=axis)


def rotate_spectrum(
    coefficients: ArrayLike, alpha: float, orders: Sequence[int] | None = None
) -> NDArray[np.complex128]:
    """The spectrum of an object turned by any angle, equation 2: a_m e^{-imα}.

    Args:
        coefficients: (…, radius, order, height) from `angular_spectrum`.
        alpha: [rad] counter-clockwise seen from above.
        orders: The orders m of the coefficients; None means all, as in `spectrum_orders`.

    Returns:
        (…, radius, order, height).

    Raises:
        InputError: Fewer than three axes, or not as many orders as coefficients.
    """
    spectrum = np.asarray(coefficients, dtype=np.complex128)
    if spectrum.ndim < 3:
        raise InputError(
            f"coefficients must have shape (…, radius, order, height), not {spectrum.shape}"
        )
    count = spectrum.shape[_azimuth_of(spectrum)]
    known = spectrum_orders(count) if orders is None else _whole(orders)
    if len(known) != count:
        raise InputError(f"{len(known)} orders for {count} coefficients; give one each")
    return spectrum * np.exp(-1j * float(alpha) * known)[:, None]


def _azimuth_of(cells: NDArray[np.generic]) -> int:
    return cells.ndim - 3 + AZIMUTH_AXIS


def _whole(orders: Sequence[int]) -> NDArray[np.int64]:
    wanted = np.asarray(orders)
    if wanted.ndim != 1 or wanted.dtype.kind not in "iu":
        raise InputError(f"orders must be a list of whole numbers, not {orders!r}")
    return wanted.astype(np.int64)
