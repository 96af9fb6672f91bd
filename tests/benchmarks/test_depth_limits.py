"""Each distance and voxel size is measured once and has its row in the tables."""

from __future__ import annotations

from benchmarks.ablation_rules import RULES
from benchmarks.depth_limits import (
    DEFAULT_DEPTH_M,
    DEFAULT_VOXEL_M,
    DEPTHS_M,
    MODEL,
    SYSTEMATIC,
    VOXELS_M,
    WHITE,
    jobs,
    page,
)


def test_settings_are_tried_once() -> None:
    found = jobs([None])
    assert len({job.key for job in found}) == len(found) == 2 * (len(DEPTHS_M) + len(VOXELS_M) - 1)
    default = [j for j in found if (j.max_depth, j.voxel) == (DEFAULT_DEPTH_M, DEFAULT_VOXEL_M)]
    assert [job.variant for job in default] == [MODEL, WHITE]


def test_parts_of_the_measurement_model_exist() -> None:
    assert set(SYSTEMATIC) <= {rule.name for rule in RULES}


def test_tables_give_errors_and_their_spread() -> None:
    runs = [
        {
            "recording": job.recording,
            "variant": job.variant,
            "max_depth_m": job.max_depth,
            "voxel_m": job.voxel,
            "ate_mm": 10.0 if job.max_depth < 4 else 25.0,
        }
        for job in jobs([None])
    ]
    lines = page(runs).splitlines()
    assert "| simulated camera | model |" + 5 * " 10.0 |" + " 25.0 | 2.50 |" in lines
    assert "| simulated camera | white noise |" + 4 * " 10.0 |" + " 1.00 |" in lines
