"""Classifying labelled real objects, by classifiers and by checkpoints."""

from __future__ import annotations

import numpy as np
import pytest
from made_crops import arrays_of, crop, write_crops
from two_kinds import ByHeight

from circumspect.classification import Classifier, GridSpec
from circumspect.classification.context import SCALE_KNOWN
from circumspect.datasets import read_labelled_crops
from circumspect.datasets.label_meaning import LabelUse
from circumspect.datasets.labelled_crops import read_crop_sources
from circumspect.errors import InputError
from circumspect.evaluation.crop_answers import answer_crops, classified
from circumspect.evaluation.crop_metrics import crop_metrics
from circumspect.geometry import PointCloud


@pytest.fixture(scope="module")
def shipped():
    return Classifier.load(threads=1)


@pytest.fixture(scope="module")
def rooms(tmp_path_factory):
    path = write_crops(tmp_path_factory.mktemp("crops") / "rooms.npz")
    return {"rooms": read_labelled_crops(path)}


def test_answers_are_those_of_the_classifier(shipped, rooms):
    reported = []
    answers = answer_crops(shipped, rooms, progress=lambda *done: reported.append(done))
    assert reported == [(k, 7) for k in range(1, 8)]
    assert [answer.use for answer in answers[-2:]] == [LabelUse.OTHER_KIND, LabelUse.LEFT_OUT]
    assert {answer.use for answer in answers[:-2]} == {LabelUse.KNOWN_CLASS}
    for index, answer in enumerate(answers):
        prediction = shipped.classify(rooms["rooms"].cloud(index), metric=True)
        assert answer.answer == prediction.label
        assert answer.probability == pytest.approx(prediction.probability)
        assert answer.distance == pytest.approx(prediction.distance)
        assert answer.confident == prediction.confident
        assert answer.scene == rooms["rooms"].scenes[index]


def test_scale_is_withheld_where_that_is_asked_for(shipped, rooms, monkeypatch):
    given = []
    classify = type(shipped).classify

    def watched(self, cloud, **options):
        given.append(options["metric"])
        return classify(self, cloud, **options)

    monkeypatch.setattr(type(shipped), "classify", watched)
    answer_crops(shipped, rooms, "unknown")
    assert given == [False] * 7
    answer_crops(shipped, rooms)
    assert given[7:] == [True] * 7


def test_a_checkpoint_answers_without_an_open_set_model(rooms):
    answers = answer_crops(ByHeight(), rooms)
    assert {answer.answer for answer in answers} <= {"flat", "tall"}
    assert all(answer.in_distribution and answer.distance is None for answer in answers)
    # None of these labels is one of its classes.
    assert crop_metrics(answers, ByHeight.classes)["objects"]["known_classes"] == 0


def test_a_checkpoint_that_takes_sizes_is_shown_them(rooms):
    given = []

    class Metric(ByHeight):
        input_spec = GridSpec(azimuth_views=2, metric=True)

        def probabilities(self, inputs, contexts=None):
            given.append(contexts)
            return super().probabilities(inputs)

    answer_crops(Metric(), rooms)
    answer_crops(Metric(), rooms, "unknown")
    known = [bool(contexts[0, SCALE_KNOWN]) for contexts in given]
    assert known == [True] * 7 + [False] * 7


@pytest.mark.parametrize(
    ("points", "why"),
    [
        (np.full((200, 3), 0.5), "lie in one place"),
        (np.linspace([0, 0, 0], [1, 1, 1], 200), "lie on a line"),
        (crop("chair", 3) * 1000, "longest side is .* m; save points in metres"),
        (crop("chair", 3) / 1000, "longest side is .* m; save points in metres"),
    ],
)
def test_an_object_that_can_not_be_classified_is_named(shipped, tmp_path, points, why):
    clouds = [crop("chair", 1), points]
    arrays = arrays_of(clouds, ["chair", "table"], ["hall", "cellar"])
    sources = read_crop_sources([write_crops(tmp_path / "house.npz", arrays)])
    with pytest.raises(InputError, match=rf"^house: object 1 \(table in cellar\): .*{why}"):
        answer_crops(shipped, sources)


def test_without_a_scale_any_size_will_do(shipped, tmp_path):
    arrays = arrays_of([crop("chair", 3) * 1000], ["chair"], ["hall"])
    sources = read_crop_sources([write_crops(tmp_path / "house.npz", arrays)])
    for predictor in (shipped, ByHeight()):
        with pytest.raises(InputError, match="save points in metres"):
            answer_crops(predictor, sources)
        assert len(answer_crops(predictor, sources, "unknown")) == 1


def test_heading_and_place_hardly_matter(shipped):
    points = crop("chair", 3)
    turned = PointCloud(points).turned(1.0)
    first = classified(shipped, PointCloud(points), "metric")
    second = classified(shipped, turned, "metric")
    assert first.label == second.label
    assert first.probability == pytest.approx(second.probability, abs=0.2)


def test_a_development_set_is_answered(data_folder, shipped):
    file = data_folder / "real_crops" / "scannet.npz"
    if not file.is_file():
        pytest.skip("no real_crops/scannet.npz in the development data")
    answers = answer_crops(shipped, read_crop_sources([file]))
    metrics = crop_metrics(answers, shipped.classes)
    assert metrics["objects"] == {
        "all": 17, "known_classes": 14, "other_kinds": 3, "left_out": 0
    }  # fmt: skip
    assert metrics["overall"]["accuracy"]["share"] > 0.5
    assert metrics["open_set"]["auroc"] is not None
