"""Files of older and newer versions."""

import json

import onnx
import pytest

from circumspect.classification import Classifier, GridSpec
from circumspect.classification.confidence_rule import ConfidenceRule
from circumspect.classification.model_description import FORMAT
from circumspect.classification.shipped import shipped_path
from circumspect.errors import WeightsError
from circumspect.export.description import describe


def described(tmp_path, **changes):
    """The classifier of the paper's protocol, with another description."""
    path = shipped_path("modelnet10")
    network = onnx.load_from_string(path.read_bytes())
    description = {**Classifier.load(path).description, **changes}
    describe(network, {key: value for key, value in description.items() if value is not None})
    out = tmp_path / "changed.onnx"
    out.write_bytes(network.SerializeToString())
    return out


def test_files_without_the_new_entries_keep_working(tmp_path):
    old = Classifier.load(described(tmp_path, format=1, confidence=None, open_set=None, other=None))
    assert old.rule == ConfidenceRule()
    assert old.open_set is None
    assert old.other is None
    assert not old.input_spec.takes_context


def test_onnx_file_of_an_earlier_format_is_converted(tmp_path):
    stored = json.loads(
        onnx.load_from_string(shipped_path("modelnet10").read_bytes()).metadata_props[0].value
    )
    assert stored["format"] < FORMAT
    assert stored["grid"]["staggered"] is True
    classifier = Classifier.load(described(tmp_path, **stored))
    assert isinstance(classifier.input_spec, GridSpec)
    assert classifier.input_spec.dithered
    assert classifier.description["format"] == FORMAT
    assert classifier.description["grid"]["dithered"] is True
    assert "staggered" not in classifier.description["grid"]


def test_entry_under_both_names_is_refused(tmp_path):
    grid = Classifier.load("modelnet10").input_spec.to_dict()
    with pytest.raises(WeightsError, match="'staggered' is the earlier name of 'dithered'"):
        Classifier.load(described(tmp_path, format=2, grid={**grid, "staggered": True}))


def test_a_file_of_a_later_version_is_refused(tmp_path):
    with pytest.raises(
        WeightsError, match=f"input format {FORMAT + 1}.*update circumspect"
    ) as error:
        Classifier.load(described(tmp_path, format=FORMAT + 1))
    assert "broken" not in str(error.value)


@pytest.mark.parametrize("number", [0, -1, 1.5, "2", True])
def test_a_format_that_is_no_version_is_refused(tmp_path, number):
    with pytest.raises(WeightsError, match="input format"):
        Classifier.load(described(tmp_path, format=number))


@pytest.mark.parametrize(
    "changes",
    [
        {"confidence": {"coverage": [0.5]}},
        {"open_set": {"bias": 1.0}},
        {"other": "sheep"},
        {"other": 3},
    ],
)
def test_broken_entries_are_refused(tmp_path, changes):
    with pytest.raises(WeightsError, match=r"broken|other things"):
        Classifier.load(described(tmp_path, **changes))


def test_a_network_that_lacks_the_context_it_describes_is_refused(tmp_path):
    input_spec = {
        **Classifier.load(shipped_path("modelnet10")).input_spec.to_dict(),
        "metric": True,
    }
    with pytest.raises(WeightsError, match="takes 1 inputs"):
        Classifier.load(described(tmp_path, grid=input_spec))
