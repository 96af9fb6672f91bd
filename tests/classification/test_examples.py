import dataclasses

import numpy as np
import pytest

from circumspect.classification import Classifier, ExampleTable, nearest_examples
from circumspect.classification.example_table import (
    examples_path,
    network_of,
    shipped_examples,
)
from circumspect.classification.model_description import OBJECTS
from circumspect.classification.onnx_classifier import OnnxClassifier
from circumspect.classification.opened_network import open_shipped
from circumspect.classification.shipped import shipped_path
from circumspect.datasets import ObjectSet, open_data_set
from circumspect.errors import InputError, WeightsError
from circumspect.export.examples import example_table
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud


@pytest.fixture(scope="module")
def classifier():
    return Classifier.load("modelnet10", threads=1)


@pytest.fixture(scope="module")
def furniture(classifier):
    names = [f"{name}_{seed}" for name in ("bed", "chair", "sofa") for seed in range(2)]
    points = [make_furniture(n[:-2], int(n[-1])).sampled(1024, 0).points_xyz for n in names]
    labels = [classifier.classes.index(name[:-2]) for name in names]
    return ObjectSet(
        np.array(points, np.float32), np.array(labels), np.array(names), classifier.classes
    )


def fitted_to(objects):
    """The shipped classifier, with these as its training objects."""
    session, description = open_shipped("modelnet10", threads=1)
    training = {**description["training"], OBJECTS: objects.names.tolist()}
    return OnnxClassifier(session, {**description, "training": training})


@pytest.fixture(scope="module")
def table(classifier, furniture):
    return example_table(fitted_to(furniture), furniture)


def test_an_example_is_its_own_nearest_one_anywhere(classifier, furniture, table):
    for index, name in enumerate(furniture.names):
        near = nearest_examples(classifier, furniture.cloud(index), 6, table)
        assert (near[0].name, near[0].distance) == (name, pytest.approx(0, abs=1e-5))
        assert [n.distance for n in near] == sorted(n.distance for n in near)
        assert len({n.name for n in near}) == 6
    cloud = furniture.cloud(3)
    quarter = PointCloud(cloud.points_xyz @ np.array([[0, 1.0, 0], [-1, 0, 0], [0, 0, 1]]))
    assert nearest_examples(classifier, quarter, 1, table)[0].name == furniture.names[3]


def test_a_table_round_trips_through_its_file(table, tmp_path):
    table.save(tmp_path / "t.npz")
    again = ExampleTable.load(tmp_path / "t.npz")
    assert (again.network, again.classes) == (table.network, table.classes)
    assert (again.names == table.names).all()
    assert (again.labels == table.labels).all()
    step = np.ptp(table.features, axis=0) / 255
    assert (np.abs(again.features - table.features) <= 0.51 * step + 1e-7).all()


def test_examples_of_modelnet10_are_the_training_split_and_small(classifier):
    shipped = shipped_examples("modelnet10")
    assert examples_path(shipped_path("modelnet10")).stat().st_size < 1_500_000
    assert len(shipped) == 3991
    assert shipped.classes == classifier.classes
    assert shipped.network == network_of(classifier)
    assert len(set(shipped.names.tolist())) == 3991


def test_shipped_examples_are_features_of_the_shipped_network(classifier, data_folder):
    objects = open_data_set(data_folder / "modelnet10", "train")
    tested = set(open_data_set(data_folder / "modelnet10", "test").names.tolist())
    assert not tested & set(shipped_examples("modelnet10").names.tolist())
    for index in range(7, len(objects), 800):
        near = nearest_examples(classifier, objects.cloud(index), 3)
        # The set holds some objects twice.
        assert near[0].distance < 1e-3
        assert objects.names[index] in [n.name for n in near if n.distance < 1e-3]


def test_only_training_objects_become_examples(classifier, furniture):
    learnt = furniture.subset(np.array([4, 1]))
    table = example_table(fitted_to(learnt), furniture)
    assert table.names.tolist() == furniture.names[[1, 4]].tolist()
    assert table.labels.tolist() == furniture.labels[[1, 4]].tolist()
    with pytest.raises(InputError, match="trained on none of the set's 6 objects"):
        example_table(classifier, furniture)


def test_plain_furniture_is_near_its_kind(classifier):
    near = nearest_examples(classifier, make_furniture("chair", 3).sampled(20_000, 0))
    assert [n.label for n in near] == ["chair"] * 5
    grid = classifier.input_spec.bounds(cloud := make_furniture("bed", 1).sampled(9000, 0)).hits(
        cloud
    )
    assert nearest_examples(classifier, grid, 1)[0].label == "bed"


def test_tables_of_other_weights_are_refused(classifier, furniture, table):
    other = dataclasses.replace(table, network="0" * 64)
    with pytest.raises(WeightsError, match="export --examples"):
        nearest_examples(classifier, furniture.cloud(0), 1, other)


def test_arguments_out_of_range(classifier, furniture, table):
    with pytest.raises(InputError, match="count"):
        nearest_examples(classifier, furniture.cloud(0), 0, table)
    with pytest.raises(InputError, match=r"must be \(256,\)"):
        table.nearest(np.zeros(3))
    with pytest.raises(InputError, match="of the classes"):
        example_table(classifier, dataclasses.replace(furniture, classes=tuple("abcdefghij")))


class TestBrokenTables:
    def test_missing_and_foreign(self, tmp_path):
        with pytest.raises(InputError, match="does not exist"):
            ExampleTable.load(tmp_path / "none.npz")
        (tmp_path / "text.npz").write_text("hello")
        with pytest.raises(InputError, match=r"text\.npz: no readable NPZ"):
            ExampleTable.load(tmp_path / "text.npz")
        np.savez(tmp_path / "other.npz", points=np.zeros((3, 3)))
        with pytest.raises(InputError, match="lacks features_u8"):
            ExampleTable.load(tmp_path / "other.npz")

    @pytest.mark.parametrize(
        "change",
        [
            {"features_u8": np.zeros((6, 3), np.uint8)},
            {"features_u8": np.zeros((6, 256), np.uint16)},
            {"features_u8": np.zeros(6, np.uint8)},
            {"features_u8": np.zeros((0, 256), np.uint8)},
            {"low": np.full(256, np.nan, np.float32)},
            {"labels": np.full(6, 10)},
            {"labels": np.full(6, 0.5)},
            {"names": np.array(["a"])},
            {"names": np.zeros(6)},
            {"classes": np.array("chair")},
            {"network": np.array([], "U64")},
            {"names": np.array([{}] * 6)},
        ],
    )
    def test_arrays_of_different_lengths(self, table, tmp_path, change):
        table.save(tmp_path / "t.npz")
        with np.load(tmp_path / "t.npz") as stored:
            arrays = dict(stored) | change
        np.savez(tmp_path / "t.npz", **arrays)
        with pytest.raises(InputError, match=r"t\.npz"):
            ExampleTable.load(tmp_path / "t.npz")
