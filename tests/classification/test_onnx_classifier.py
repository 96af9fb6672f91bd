import copy
import json
import pickle
from contextlib import suppress

import numpy as np
import onnx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.classification import (
    Classifier,
    GridSpec,
    OnnxClassifier,
    Prediction,
    input_spec_from_dict,
)
from circumspect.classification.cloud_checks import MIN_POINTS
from circumspect.classification.model_description import METADATA_KEY
from circumspect.classification.opened_network import open_shipped
from circumspect.classification.shipped import shipped_path
from circumspect.classification.upright import classify_any_way_up
from circumspect.datasets import open_data_set
from circumspect.errors import GeometryError, InputError, WeightsError
from circumspect.furniture import make_furniture
from circumspect.geometry import PointCloud
from circumspect.grid import CylindricalGrid, OccupancyGrid


@pytest.fixture(scope="module")
def classifier():
    return Classifier.load("modelnet10", threads=1)


@pytest.fixture(scope="module")
def shipped_bytes():
    return shipped_path("modelnet10").read_bytes()


def turned(cloud, yaw):
    c, s = np.cos(yaw), np.sin(yaw)
    return PointCloud(cloud.points_xyz @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]))


def test_modelnet10_has_the_classes_of_its_data(classifier):
    assert classifier.classes == (
        "bathtub", "bed", "chair", "desk", "dresser",
        "monitor", "night_stand", "sofa", "table", "toilet",
    )  # fmt: skip
    assert len(classifier.description["training"])


@pytest.mark.parametrize("category", ["chair", "sofa", "monitor", "bed"])
def test_classifies_plain_furniture_and_measures_the_time(classifier, category):
    prediction = classifier.classify(make_furniture(category, 0).sampled(20_000, 0))
    assert prediction.label == category
    assert prediction.probability == max(prediction.probabilities.values())
    assert sum(prediction.probabilities.values()) == pytest.approx(1.0)
    assert set(prediction.milliseconds) == {"grid", "classify"}


@settings(max_examples=15)
@given(
    cells=st.integers(1, 31),
    scale=st.sampled_from([1e-9, 1e-3, 1.0, 1e6, 1e12]),
    shift=st.tuples(*[st.floats(-2, 2)] * 3),
)
def test_whole_cells_scale_and_place_do_not_matter(classifier, cells, scale, shift):
    cloud = make_furniture("chair", 4).sampled(20_000, 1)
    reference = classifier.classify(cloud)
    moved = turned(cloud, 2 * np.pi * cells / classifier.input_spec.shape[1])
    moved = PointCloud((moved.points_xyz + shift) * scale)
    answer = classifier.classify(moved)
    assert answer.label == reference.label
    # A few points on cell boundaries may fall either way.
    assert answer.probability == pytest.approx(reference.probability, abs=0.02)


def test_sparse_clouds_are_filled(classifier):
    sparse = make_furniture("chair", 5).sampled(1024, 0)
    assert len(classifier.input_spec.surface(sparse)) > 8000
    assert classifier.classify(sparse).label == "chair"
    dense = make_furniture("chair", 5).sampled(30_000, 0)
    assert classifier.input_spec.surface(dense) is dense


def test_a_saved_grid_is_named_like_its_cloud(classifier, tmp_path):
    cloud = make_furniture("sofa", 1).sampled(30_000, 0)
    grid = CylindricalGrid.fit(cloud, classifier.input_spec.shape).hits(cloud.points_xyz)
    assert classifier.classify_grid(grid).label == classifier.classify(cloud).label


@pytest.mark.parametrize("yaw", [0.0, 0.1, 2.0])
def test_grids_of_all_views_are_named_as_the_cloud_is(classifier, yaw):
    cloud = turned(make_furniture("night_stand", 3).sampled(30_000, 0), yaw)
    bounds = classifier.input_spec.all_bounds(classifier.input_spec.bounds(cloud))
    assert len(bounds) == classifier.input_spec.azimuth_views > 1
    named = classifier.classify_grid(*(grid.hits(cloud.points_xyz) for grid in bounds))
    expected = classifier.classify(cloud).probabilities
    # A point on the edge of a cell may round to either side.
    assert named.probabilities == pytest.approx(expected, abs=1e-3)


def test_no_grids_are_refused(classifier):
    with pytest.raises(InputError, match="there is no grid"):
        classifier.classify_grid()


def test_other_grids_are_refused(classifier):
    with pytest.raises(InputError, match=r"the classifier expects cylindrical"):
        classifier.classify_grid(CylindricalGrid((8, 8, 8)).hits(np.zeros((1, 3))))


@pytest.mark.parametrize(
    "points",
    [np.zeros((1, 3)), np.ones((50, 3)), np.linspace(0, 1, 50)[:, None] * np.ones(3)],
    ids=["one point", "one place", "a line"],
)
def test_points_without_a_shape_are_refused(classifier, points):
    with pytest.raises(GeometryError):
        classifier.classify(PointCloud(points))


class TestLoading:
    def test_missing_folder_and_foreign_files(self, tmp_path):
        with pytest.raises(WeightsError, match="no such file"):
            Classifier.load(tmp_path / "none.onnx")
        with pytest.raises(WeightsError, match=r"is a folder; .* circumspect export makes"):
            Classifier.load(tmp_path)
        (tmp_path / "text.onnx").write_text("hello")
        with pytest.raises(WeightsError, match="not an ONNX network"):
            Classifier.load(tmp_path / "text.onnx")

    def test_truncated_file(self, tmp_path, shipped_bytes):
        path = tmp_path / "half.onnx"
        path.write_bytes(shipped_bytes[: len(shipped_bytes) // 2])
        with pytest.raises(WeightsError, match=r"half\.onnx"):
            Classifier.load(path)

    @pytest.mark.parametrize(
        ("change", "complaint"),
        [
            (lambda d: None, "another program"),
            (lambda d: {**d, "classes": d["classes"][:3]}, "3 classes"),
            (lambda d: {**d, "grid": {**d["grid"], "shape": [16, 16, 16]}}, "export it again"),
            (lambda d: {"classes": d["classes"]}, "description is broken"),
            (lambda d: {**d, "grid": {**d["grid"], "colour": 1}}, "colour"),
        ],
    )
    def test_description_that_does_not_fit(self, tmp_path, shipped_bytes, change, complaint):
        network = onnx.load_from_string(shipped_bytes)
        (entry,) = network.metadata_props
        changed = change(json.loads(entry.value))
        if changed is None:
            entry.key = "other"
        else:
            assert entry.key == METADATA_KEY
            entry.value = json.dumps(changed)
        onnx.save(network, tmp_path / "changed.onnx")
        with pytest.raises(WeightsError, match=complaint):
            Classifier.load(tmp_path / "changed.onnx")

    def test_any_broken_file_is_a_known_error(self, tmp_path, shipped_bytes):
        rng = np.random.default_rng(0)
        path = tmp_path / "mutated.onnx"
        for _ in range(25):
            content = bytearray(shipped_bytes)
            end = len(content) if rng.random() < 0.5 else 4000
            for place in rng.integers(0, end, 20):
                content[place] = rng.integers(256)
            tail = content[-3000:]
            content[-3000:] = bytes(tail) if rng.random() < 0.5 else rng.bytes(3000)
            path.write_bytes(content)
            with suppress(WeightsError):
                classifier = Classifier.load(path, threads=1)
                assert classifier.classes

    @pytest.mark.parametrize(
        "change",
        [
            {"temperature": 0},
            {"temperature": "1"},
            {"temperature": float("nan")},
            {"classes": ["a"] * 10},
            {"grid": {"azimuth_views": 0}},
            {"grid": {"azimuth_views": "2"}},
            {"grid": {"kind": "spherical"}},
        ],
    )
    def test_invalid_descriptions_are_refused(self, tmp_path, shipped_bytes, change):
        network = onnx.load_from_string(shipped_bytes)
        (entry,) = network.metadata_props
        described = json.loads(entry.value)
        described["grid"] |= change.pop("grid", {})
        entry.value = json.dumps(described | change)
        onnx.save(network, tmp_path / "changed.onnx")
        with pytest.raises(WeightsError, match="description is broken"):
            Classifier.load(tmp_path / "changed.onnx")


def test_threads_below_zero():
    with pytest.raises(InputError, match="threads"):
        Classifier.load(threads=-1)


def test_a_few_points_are_out_of_distribution(classifier):
    """The first three are near enough to a training chair to be called one (0.94)."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 1]])
    assert not classifier.classify(PointCloud(points)).in_distribution
    chair = make_furniture("chair", 3).sampled(MIN_POINTS, 0).points_xyz
    assert classifier.classify(PointCloud(chair)).in_distribution
    assert not classifier.classify(PointCloud(chair[1:])).in_distribution


def test_repeated_points_count_once(classifier):
    few = make_furniture("chair", 3).sampled(MIN_POINTS - 1, 0).points_xyz
    assert not classifier.classify(PointCloud(np.tile(few, (50, 1)))).in_distribution
    enough = make_furniture("chair", 3).sampled(2_000, 0).points_xyz
    assert classifier.classify(PointCloud(np.repeat(enough, 50, axis=0))).in_distribution


def test_a_copy_of_the_shipped_file_finds_unknown_objects(shipped_bytes, tmp_path):
    (tmp_path / "copy.onnx").write_bytes(shipped_bytes)
    copy = Classifier.load(tmp_path / "copy.onnx")
    assert not copy.classify(PointCloud([[0.0, 0, 0], [1, 0, 0], [0, 1, 1]])).in_distribution


def test_prediction_from_a_vector():
    prediction = Prediction.from_probabilities(("a", "b"), np.array([0.25, 0.75]))
    assert (prediction.label, prediction.probability) == ("b", 0.75)
    assert prediction.in_distribution
    assert prediction.distance is None
    far = Prediction.from_probabilities(
        ("a", "b"), np.array([0.4, 0.6]), in_distribution=False, distance=0.7
    )
    assert not far.in_distribution
    assert far.distance == 0.7
    with pytest.raises(TypeError):
        prediction.probabilities["a"] = 1.0  # type: ignore[index]


@given(views=st.integers(1, 4), kind=st.sampled_from(["cylindrical", "rectangular"]))
def test_input_spec_round_trips_through_json(views, kind):
    input_spec = GridSpec(kind=kind, shape=(8, 16, 4), azimuth_views=views)
    assert input_spec_from_dict(json.loads(json.dumps(input_spec.to_dict()))) == input_spec


def test_views_of_a_rectangular_grid_are_all_the_same():
    """They are redundant, but files may request them."""
    cloud = make_furniture("table", 2).sampled(20_000, 0)
    first, second = GridSpec("rectangular", azimuth_views=2).grids(cloud)[0]
    np.testing.assert_array_equal(first, second)


def test_views_are_turned_by_fractions_of_a_cell():
    cloud = make_furniture("table", 2).sampled(20_000, 0)
    grids = GridSpec(azimuth_views=4).grids(cloud)[0]
    fraction = 2 * np.pi / 32 / 4
    for view in range(4):
        turned_grid = GridSpec().grids(turned(cloud, view * fraction))[0, 0]
        assert (grids[view] != turned_grid).mean() < 1e-3


def test_real_objects_are_classified_at_any_yaw(classifier, data_folder):
    """Objects that the network was trained on: this shows that nothing broke on the way."""
    objects = open_data_set(data_folder / "modelnet10", "train")
    chosen = objects.subset(np.arange(0, len(objects), 80))
    grids = np.stack(
        [classifier.input_spec.grids(chosen.cloud(i), [0.0, 1.234]) for i in range(len(chosen))]
    )
    answers = [classifier.probabilities(grids[:, k]).argmax(axis=1) for k in range(2)]
    for answer in answers:
        assert (answer == chosen.labels).mean() > 0.95
    assert (answers[0] == answers[1]).mean() > 0.95


def test_load_is_the_same_from_the_interface_and_the_class():
    assert OnnxClassifier.load("modelnet10").classes == Classifier.load("modelnet10").classes


def test_a_fallen_object_is_stood_up(classifier):
    """Most objects are stood up and classified correctly; as they lie, few are."""
    right = {"auto": 0, "as it lies": 0}
    for number, category in enumerate(("chair", "table", "toilet", "bed") * 3):
        rotation = Rotation.random(rng=np.random.default_rng(number))
        matrix = RigidTransform.from_rotation(rotation).as_matrix()
        cloud = make_furniture(category, number).sampled(8000, number).moved(matrix)
        prediction, pose = classify_any_way_up(classifier, cloud)
        right["auto"] += prediction.label == category
        right["as it lies"] += classifier.classify(cloud).label == category
        assert (
            prediction.label
            == classifier.classify(
                cloud.moved(RigidTransform.from_rotation(pose).as_matrix())
            ).label
        )
    assert right["auto"] > 8
    assert right["auto"] > right["as it lies"] + 2


def test_more_threads_than_any_machine_has():
    with pytest.raises(InputError, match="threads"):
        Classifier.load(threads=99_999_999_999)


def test_an_empty_grid_is_refused(classifier):
    grid = CylindricalGrid()
    nothing = OccupancyGrid(grid, np.zeros(grid.shape, np.uint8))
    with pytest.raises(InputError, match="the grid is empty"):
        classifier.classify_grid(nothing)


def test_the_same_cloud_gives_an_equal_answer(classifier):
    cloud = make_furniture("chair", 0).sampled(2000, 0)
    assert classifier.classify(cloud) == classifier.classify(cloud)


def test_a_pickled_classifier_is_loaded_again(classifier, shipped_bytes, tmp_path, monkeypatch):
    cloud = make_furniture("chair", 0).sampled(2000, 0)
    (tmp_path / "own.onnx").write_bytes(shipped_bytes)
    monkeypatch.chdir(tmp_path)
    own = Classifier.load("own.onnx", threads=1)
    expected = own.classify(cloud)
    # The other process may have another working directory.
    monkeypatch.chdir("/")
    assert pickle.loads(pickle.dumps(own)).classify(cloud) == expected
    assert copy.deepcopy(classifier).classify(cloud) == classifier.classify(cloud)


def test_a_classifier_from_no_file_can_not_be_pickled():
    bare = OnnxClassifier(*open_shipped("modelnet10", threads=1))
    with pytest.raises(TypeError, match=r"Classifier\.load\(model\)"):
        pickle.dumps(bare)


def test_an_array_is_named_as_the_cloud_of_its_points(classifier):
    points = make_furniture("chair", 0).sampled(2000, 0).points_xyz
    assert classifier.classify(points) == classifier.classify(PointCloud(points))


def test_wrong_cloud_types_are_refused_with_a_remedy(classifier):
    with pytest.raises(InputError, match=r"mesh\.sampled\("):
        classifier.classify(make_furniture("chair", 0))
    with pytest.raises(InputError, match=r"circumspect\.read_cloud\(path\)"):
        classifier.classify("chair.ply")


def test_wrong_grid_types_are_refused(classifier):
    cloud = make_furniture("chair", 0).sampled(20_000, 0)
    bounds = classifier.input_spec.bounds(cloud)
    with pytest.raises(InputError, match=r"not a list; of several: classify_grid\(\*views\)"):
        classifier.classify_grid([bounds.hits(cloud)])
    with pytest.raises(InputError, match=r"bounds\.hits\(points\)"):
        classifier.classify_grid(bounds)


def test_repr_of_a_classifier_is_short(classifier):
    views = classifier.input_spec.azimuth_views
    reported = f"OnnxClassifier(10 classes, cylindrical 32x32x32, {views} dithered views)"
    assert repr(classifier) == reported


def test_a_stretched_grid_is_refused(classifier):
    """Without the check the answer was a bed in distribution, with 0.96."""
    cloud = make_furniture("chair", 3).sampled(20_000, 0)
    flat = CylindricalGrid.fit(cloud, half_height_per_radius=4).hits(cloud.points_xyz)
    with pytest.raises(
        InputError, match=r"4 times as high as wide; make it by classifier\.input_spec"
    ):
        classifier.classify_grid(flat)
