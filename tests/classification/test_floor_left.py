"""A floor that was left in is neither part of the object nor a table."""

from __future__ import annotations

import numpy as np
import pytest

from circumspect.classification import Classifier
from circumspect.classification.cloud_checks import holds_floor
from circumspect.cli.main import main
from circumspect.datasets import open_data_set
from circumspect.furniture import CATEGORIES, make_furniture


def with_floor(category: str, beyond: float, share: float, noise: float = 0.0) -> np.ndarray:
    """An object on a disc that reaches `beyond` times as far and has a share of the points."""
    rng = np.random.default_rng(0)
    points = make_furniture(category, 3).sampled(20_000, 0).points_xyz
    count = int(share * len(points) / (1 - share))
    reach = beyond * np.hypot(*points[:, :2].T).max()
    angle, away = rng.uniform(0, 2 * np.pi, count), reach * np.sqrt(rng.uniform(0, 1, count))
    level = np.full(count, points[:, 2].min())
    both = np.concatenate(
        [points, np.column_stack([away * np.cos(angle), away * np.sin(angle), level])]
    )
    return both + rng.normal(0, noise, both.shape)


@pytest.mark.parametrize("category", CATEGORIES)
@pytest.mark.parametrize(("beyond", "share"), [(1.3, 0.3), (2.0, 0.6)])
def test_a_floor_is_found(category: str, beyond: float, share: float) -> None:
    assert holds_floor(with_floor(category, beyond, share))
    assert not holds_floor(with_floor(category, 1.0, 0.0))


@pytest.mark.parametrize("category", ["chair", "bed", "monitor"])
def test_a_floor_of_a_depth_camera_is_found(category: str) -> None:
    assert holds_floor(with_floor(category, 1.3, 0.3, noise=0.004))


def test_few_real_objects_seem_to_have_a_floor(data_folder) -> None:
    objects = open_data_set(data_folder / "modelnet10", "train")
    some = range(0, len(objects), 5)
    found = sum(holds_floor(objects.points_xyz[index]) for index in some)
    assert found <= 0.01 * len(some)


def test_an_object_with_its_floor_is_unknown(tmp_path, capsys) -> None:
    """Nine in ten points of floor are a table top to the network."""
    both = with_floor("chair", 1.5, 0.5)
    assert not Classifier.load("modelnet10").classify(both).in_distribution
    np.save(tmp_path / "scan.npy", both)
    assert main(["classify", str(tmp_path / "scan.npy")]) == 0
    reported = capsys.readouterr()
    assert "scan.npy: unknown object (nearest: " in reported.out
    assert reported.err.count("\n") == 1
    assert "scan.npy: seems to hold the floor, too; cut it off: --cut-floor" in reported.err
