"""An exported file returns the distance to the nearest training object of its table."""

from __future__ import annotations

import numpy as np
import pytest

from circumspect import Classifier, make_furniture
from circumspect.classification.example_table import shipped_examples
from circumspect.errors import WeightsError
from circumspect.furniture.other_things import make_other_thing


@pytest.mark.parametrize("kind", ["chair", "sofa"])
def test_the_shipped_file_returns_the_distance_of_its_table(kind):
    classifier = Classifier.load("modelnet10", threads=1)
    # Of one view: the file averages distances over views, the table compares their mean.
    inputs = classifier.input_spec.inputs(make_furniture(kind, 3).sampled(8000, 0))[:, :1]
    nearest = shipped_examples("modelnet10").nearest(classifier.features(inputs)[0], 1)
    assert classifier.distances(inputs)[0] == pytest.approx(nearest[0].distance, abs=2e-3)


def test_training_objects_are_near_and_other_things_far():
    classifier = Classifier.load("modelnet10", threads=1)
    known = classifier.classify(make_furniture("chair", 3).sampled(32768, 0))
    assert known.in_distribution
    strange = classifier.classify(make_other_thing("bottle", 0).sampled(32768, 0))
    assert known.distance is not None
    assert strange.distance is not None
    assert strange.distance > 3 * known.distance


def test_without_labelled_surfaces_there_is_no_distance(tmp_path):
    pytest.importorskip("torch")
    from circumspect.export import export_onnx
    from circumspect.nets import Checkpoint, build_net
    from circumspect.nets.registry import net_spec

    input_spec = net_spec("planes").input_spec
    net = build_net("planes", 2, input_spec)
    export_onnx(
        [Checkpoint("planes", ("bed", "chair"), input_spec, dict(net.state_dict()), {})],
        tmp_path / "net.onnx",
    )
    classifier = Classifier.load(tmp_path / "net.onnx")
    with pytest.raises(WeightsError, match="--examples"):
        classifier.distances(np.zeros((1, 1, *input_spec.input_shape), np.uint8))
