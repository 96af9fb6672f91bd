"""What the paper reports."""

from __future__ import annotations

ANGLES_DEG = (0.0, 45.0, 90.0, 135.0)
"""Of section 4: trained at the first, tested at all."""
MODELNET10 = {
    ("rectangular", "max"): (0.82, 0.28, 0.43, 0.20),
    ("rectangular", "rwmp"): (0.82, 0.45, 0.41, 0.29),
    ("cylindrical", "max"): (0.88, 0.58, 0.28, 0.35),
    ("cylindrical", "rwmp"): (0.87, 0.86, 0.84, 0.83),
}
"""Table 2, ModelNet10: accuracy at `ANGLES_DEG` by grid and pooling."""
ROBOT = {
    ("rectangular", "max"): (0.91, 0.16, 0.33, 0.17),
    ("rectangular", "rwmp"): (0.92, 0.26, 0.46, 0.33),
    ("cylindrical", "max"): (0.93, 0.33, 0.33, 0.16),
    ("cylindrical", "rwmp"): (0.91, 0.89, 0.91, 0.88),
}
"""Table 2, the robot's own set: accuracy at `ANGLES_DEG` by grid and pooling."""
