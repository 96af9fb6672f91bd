"""Laws of taught classes, on features that are made up, and their files."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from circumspect.classification import Classifier
from circumspect.classification.taught_classes import NOT_OF_IT, TaughtClass, TaughtClasses
from circumspect.classification.taught_file import TaughtFile
from circumspect.errors import InputError, WeightsError

LAMP = TaughtClass("lamp", np.eye(4, dtype=np.float32)[:2], 0.1, 2.0)
ROWS = arrays(np.float64, (3, 4), elements=st.floats(-5, 5))


def softmax(logits):
    powers = np.exp(logits - logits.max(axis=1, keepdims=True))
    return powers / powers.sum(axis=1, keepdims=True)


@given(ROWS, st.floats(0.5, 2.0))
def test_answers_about_other_objects_stay(logits, temperature):
    """Nothing is within the radius: only the new column is added, of no weight."""
    features = np.tile([0.0, 0.0, 1.0, 0.2], (3, 1))
    nearest = np.array([0.3, 0.2, 0.0])
    taught = TaughtClasses([LAMP], temperature)
    after, distances = taught.completed(logits, features, nearest)
    assert np.array_equal(after[:, :-1], logits)
    assert np.array_equal(distances, nearest)
    shares = softmax(after / temperature)
    assert np.allclose(shares[:, :-1], softmax(logits / temperature), atol=1e-12)
    assert shares[:, -1].max() < 1e-12


@given(ROWS, st.floats(0.5, 2.0), st.floats(0.001, 0.3), st.floats(0.001, 0.3))
def test_object_is_of_the_class_that_is_nearest_within_the_radius(
    logits, temperature, angle, nearest
):
    feature = np.array([[np.cos(angle), 0.0, np.sin(angle), 0.0]])
    distance = 1 - np.cos(angle)
    after, distances = TaughtClasses([LAMP], temperature).completed(
        logits[:1], feature, np.array([nearest])
    )
    share = softmax(after / temperature)[0, -1]
    bound = min(LAMP.radius, nearest)
    if abs(distance - bound) > 1e-9:
        assert (share > 0.5) == (distance < bound)
    if share > 0.5:
        assert share == pytest.approx(1 / (1 + (distance / bound) ** LAMP.slope), rel=1e-3)
        assert distances[0] == pytest.approx(distance, abs=1e-5)


def test_nearer_of_two_taught_classes_wins():
    fan = TaughtClass("fan", np.array([[0.9, 0.0, 0.436, 0.0]], np.float32), 0.2, 2.0)
    feature = np.array([[1.0, 0.0, 0.05, 0.0]])
    after, _ = TaughtClasses([LAMP, fan], 1.0).completed(np.zeros((1, 3)), feature, None)
    assert after[0].argmax() == 3
    assert after[0, 4] < NOT_OF_IT / 2


@given(
    arrays(np.float32, (3, 5), elements=st.floats(0.125, 8, width=32)),
    st.floats(0.001, 2), st.floats(0.01, 20),
)  # fmt: skip
def test_class_is_read_back(features, radius, slope):
    again = TaughtClass.from_dict(
        json.loads(json.dumps(TaughtClass("x", features, radius, slope).to_dict()))
    )
    assert (again.name, again.radius, again.slope) == ("x", radius, slope)
    assert np.allclose(again.features, features, rtol=1e-5)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"name": 3}, "needs a name"),
        ({"features": "abc"}, "rows of numbers"),
        ({"features": [[1, 2], [3]]}, "rows of numbers"),
        ({"features": []}, r"must be \(n, f\)"),
        ({"features": [[0, 0]]}, "not all zero"),
        ({"features": [[float("nan"), 0]]}, "finite"),
        ({"radius": 0}, "radius of lamp must lie in 0 … 2"),
        ({"radius": None}, "radius of lamp must lie"),
        ({"slope": True}, "slope of lamp must lie"),
    ],
)
def test_broken_class_is_refused(entry, message):
    with pytest.raises(InputError, match=message):
        TaughtClass.from_dict({**LAMP.to_dict(), **entry})


@pytest.fixture
def taught_file(tmp_path):
    import hashlib

    from circumspect.classification.shipped import shipped_path

    sha256 = hashlib.sha256(shipped_path("robot").read_bytes()).hexdigest()
    features = np.random.default_rng(0).random((5, 256), np.float32)
    lamp = TaughtClass("lamp", features, 0.1, 2.0)
    TaughtFile("robot", sha256, (lamp,), {"lamp": ("ab",) * 5}).save(tmp_path / "own.json")
    return tmp_path / "own.json"


def test_file_is_a_classifier_of_one_class_more(taught_file):
    base, own = Classifier.load("robot", 1), Classifier.load(taught_file, 1)
    assert own.classes == (*base.classes, "lamp")
    assert own.other == base.other
    assert own.description["taught"] == {"lamp": 5}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.pop("circumspect_taught"), "not a taught classifier"),
        (lambda d: d.update(circumspect_taught=2), "format 2; this version reads 1; update"),
        (lambda d: d.update(sha256="00"), "is another network than the one that was taught"),
        (lambda d: d.update(base="gone.onnx"), "gone.onnx, can not be read"),
        (lambda d: d.update(base="a\0b"), "does not name the classifier"),
        (lambda d: d.update(base="../robot.onnx"), "does not name the classifier"),
        (lambda d: d.update(base="/dev/zero"), "does not name the classifier"),
        (lambda d: d.update(base=".."), "it is no onnx file"),
        (lambda d: d.update(classes=[]), "no classes"),
        (lambda d: d.update(classes=d["classes"] * 2), "not distinct"),
        (lambda d: d.update(examples=[]), "does not name its examples"),
        (lambda d: d["classes"][0].update(name="chair"), "names chair already"),
        (lambda d: d["classes"][0].update(features=[[1.0, 2.0]]), "taught by 2 features"),
    ],
)
def test_a_broken_file_is_refused(taught_file, change, message):
    document = json.loads(taught_file.read_text())
    change(document)
    taught_file.write_text(json.dumps(document))
    with pytest.raises(WeightsError, match=message) as caught:
        Classifier.load(taught_file)
    assert str(caught.value).startswith(str(taught_file))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "[", "[]", "{}", "[" * 9000])
def test_other_json_is_no_classifier(tmp_path, text):
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(WeightsError, match=r"x\.json: not a taught classifier"):
        Classifier.load(tmp_path / "x.json")
