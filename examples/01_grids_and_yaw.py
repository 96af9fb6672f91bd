"""A turn of the object is a shift of its cylindrical grid; a cube's changes in no simple way.

python examples/01_grids_and_yaw.py
"""

import numpy as np

import circumspect as cs
from circumspect.grid import AZIMUTH_AXIS


def share_kept(one: np.ndarray, other: np.ndarray) -> float:
    """Cells that are occupied in both, as a share of those that are in either."""
    return float((one & other).sum() / (one | other).sum())


def main() -> None:
    """Compare the grids of a chair before and after turns."""
    chair = cs.make_furniture("chair", 3).sampled(200_000, rng=0)
    cylinder = cs.CylindricalGrid.fit(chair)
    grid = cylinder.hits(chair)
    cells = grid.occupied.shape[AZIMUTH_AXIS]
    print(f"{grid.occupied.sum()} of {grid.occupied.size} cells are occupied")

    # Bounds are fitted again, as for every cloud: nothing depends on the turn.
    for yaw_deg in (45.0, 90.0, 100.0):
        moved = chair.turned(np.radians(yaw_deg))
        later = cs.CylindricalGrid.fit(moved).hits(moved)
        shift = yaw_deg / 360 * cells
        shifted = np.roll(grid.occupied, round(shift), axis=AZIMUTH_AXIS)

        # The same cube both times, round the object at every yaw.
        cube = cs.RectangularGrid(half_width=cylinder.radius, centre_xyz=cylinder.centre_xyz)
        other = cs.RectangularGrid(half_width=cube.half_width, centre_xyz=later.grid.centre_xyz)
        stayed = share_kept(cube.hits(chair).occupied, other.hits(moved).occupied)
        print(
            f"{yaw_deg:5.1f} deg is {shift:.2f} cells: {share_kept(shifted, later.occupied):4.0%} "
            f"are where a shift puts them; of the cube's {stayed:4.0%} stayed"
        )


if __name__ == "__main__":
    main()
