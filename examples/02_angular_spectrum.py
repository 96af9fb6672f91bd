"""Fourier coefficients along the azimuth: a turn changes their phases alone (equations 1 and 2).

python examples/02_angular_spectrum.py
"""

import numpy as np

import circumspect as cs
from circumspect.grid import rotate_spectrum, spectrum_orders


def spectrum_of(cloud: cs.PointCloud) -> np.ndarray:
    """(radius, order, height) coefficients of the cloud's occupancy grid."""
    return cs.angular_spectrum(cs.CylindricalGrid.fit(cloud).hits(cloud))


def main() -> None:
    """Find from two spectra by how much an object was turned."""
    yaw_deg = 100.0
    desk = cs.make_furniture("desk", 5).sampled(100_000, rng=0)
    spectrum, later = spectrum_of(desk), spectrum_of(desk.turned(np.radians(yaw_deg)))

    # The power of an order does not depend on the yaw: a fingerprint of the object.
    orders = spectrum_orders(spectrum.shape[1])
    power, power_later = (np.square(np.abs(a)).sum(axis=(0, 2)) for a in (spectrum, later))
    for order in (0, 1, 2, 4):
        at = int(np.flatnonzero(orders == order)[0])
        print(f"power of order {order}: {power[at]:7.4f}, after the turn {power_later[at]:7.4f}")

    # The phases do: the angle that turns one spectrum into the other.
    angles_deg = np.arange(0.0, 360.0, 0.5)
    gaps = [np.abs(rotate_spectrum(spectrum, a) - later).sum() for a in np.radians(angles_deg)]
    found_deg = angles_deg[int(np.argmin(gaps))]
    print(f"turned by {yaw_deg:.1f} deg; estimated from the spectra: {found_deg:.1f} deg")


if __name__ == "__main__":
    main()
