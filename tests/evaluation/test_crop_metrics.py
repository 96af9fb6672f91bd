"""Metrics on real objects: laws, and results computed by hand."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import mannwhitneyu

from circumspect.datasets.label_meaning import LabelUse
from circumspect.errors import InputError
from circumspect.evaluation.accuracy import area_under_curve
from circumspect.evaluation.calibration import reliability
from circumspect.evaluation.crop_answers import CropAnswer
from circumspect.evaluation.crop_metrics import BIN_EDGES, crop_metrics, open_set_scores
from circumspect.evaluation.crop_report import command_block, report_of, shortened

CLASSES = ("bed", "chair", "sofa")


def answer(label="chair", p=(0.1, 0.8, 0.1), *, use=None, scene="room", source="file", **others):
    """An answer; known classes are named as such."""
    known = label in CLASSES
    use = use or (LabelUse.KNOWN_CLASS if known else LabelUse.OTHER_KIND)
    values = {
        "confident": max(p) >= 0.9, "reason": "", "in_distribution": True,
        "in_distribution_probability": None, "distance": None, "alternatives": {},
    } | others  # fmt: skip
    return CropAnswer(
        source=source, scene=scene, name="0000", label=label, use=use,
        true_class=label if use is LabelUse.KNOWN_CLASS else "",
        answer=CLASSES[int(np.argmax(p))], probabilities=dict(zip(CLASSES, p, strict=True)),
        **values,
    )  # fmt: skip


@st.composite
def some_answers(draw, least=1):
    """Answers of any kind, with or without open-set measures."""
    measure = draw(st.sampled_from(["in_distribution_probability", "distance", None]))
    found = []
    for _ in range(draw(st.integers(least, 12))):
        powers = np.array(draw(st.tuples(*[st.floats(0.01, 1.0)] * 3)))
        p = tuple((powers / powers.sum()).tolist())
        label = draw(st.sampled_from([*CLASSES, "lamp", "cart", "armchair"]))
        use = LabelUse.LEFT_OUT if label == "armchair" else None
        others = {} if measure is None else {measure: draw(st.floats(0, 1))}
        found.append(
            answer(
                label, p, use=use, scene=draw(st.sampled_from(["a", "b"])),
                source=draw(st.sampled_from(["x", "y"])), confident=draw(st.booleans()),
                in_distribution=draw(st.booleans()), **others,
            )
        )  # fmt: skip
    return found


@given(some_answers())
def test_parts_add_up_to_the_whole(answers):
    metrics = crop_metrics(answers, CLASSES)
    known = metrics["objects"]["known_classes"]
    assert metrics["objects"]["all"] == len(answers) == sum(list(metrics["objects"].values())[1:])
    correct = metrics["overall"]["accuracy"]["hits"]
    assert np.sum(metrics["confusion"]) == known
    assert np.trace(metrics["confusion"]) == correct
    for rows in (
        metrics["per_source"].values(), metrics["per_class"].values(), metrics["per_scene"],
        metrics["probability_bins"],
    ):  # fmt: skip
        assert sum(row["objects"] for row in rows) == known
        assert sum(row["hits"] for row in rows) == correct
    parts = metrics["confident"]
    for key in ("confident", "correct"):
        assert parts["all"][key]["hits"] == (
            parts["known_classes"][key]["hits"] + parts["other_kinds"][key]["hits"]
        )
    assert parts["other_kinds"]["correct"]["hits"] == 0
    assert correct <= metrics["overall"]["top_2"]["hits"] <= known
    others = metrics["other_kind_answers"].values()
    assert sum(sum(row.values()) for row in others) == metrics["objects"]["other_kinds"]


@given(some_answers())
def test_measures_are_json_and_the_report_fits_80_columns(answers):
    metrics = {
        **crop_metrics(answers, CLASSES),
        "command": "circumspect evaluate " + 9 * "--data rooms.npz ",
    }
    json.dumps(metrics, allow_nan=False)
    text = report_of(metrics, ["errors.png"])
    assert max(map(len, text.splitlines())) <= 80


@given(some_answers())
def test_answers_are_read_back(answers):
    for one in answers:
        assert CropAnswer.from_dict(json.loads(json.dumps(one.to_dict()))) == one


@pytest.mark.parametrize(
    "changes",
    [{"use": "maybe"}, {"answer": "mug"}, {"true_class": "mug"}, {"probabilities": [0.5]},
     {"probabilities": {"chair": "much"}}, {"confident": "yes"}, {"distance": float("nan")},
     {"label": 3}, {"more": 1}, {"alternatives": None}],
)  # fmt: skip
def test_documents_that_are_no_answers_are_refused(changes):
    with pytest.raises(InputError, match="holds no answer"):
        CropAnswer.from_dict({**answer().to_dict(), **changes})
    for document in (None, [], "chair", {}):
        with pytest.raises(InputError, match="holds no answer"):
            CropAnswer.from_dict(document)


def test_top_2_counts_the_second_best_class():
    answers = [answer("bed", (0.3, 0.6, 0.1)), answer("sofa", (0.3, 0.6, 0.1)), answer("chair")]
    overall = crop_metrics(answers, CLASSES)["overall"]
    assert overall["accuracy"]["hits"] == 1
    assert overall["top_2"]["hits"] == 2
    assert overall["mean_class_accuracy"] == pytest.approx(1 / 3)


def test_calibration_error_equals_that_of_the_reliability_over_the_same_bins():
    rng = np.random.default_rng(0)
    p = rng.dirichlet([0.3, 0.3, 0.3], 200)
    labels = rng.integers(0, 3, 200)
    answers = [answer(CLASSES[k], tuple(row)) for k, row in zip(labels, p.tolist(), strict=True)]
    found = crop_metrics(answers, CLASSES)
    confidence, right = p.max(axis=1), p.argmax(axis=1) == labels
    bins = np.digitize(confidence, BIN_EDGES[1:-1], right=True)
    by_hand = sum(
        abs(right[bins == b].sum() - confidence[bins == b].sum()) for b in range(len(BIN_EDGES) - 1)
    )
    assert found["expected_calibration_error"] == pytest.approx(by_hand / 200)
    fine = reliability(p, labels).expected_error
    assert found["expected_calibration_error"] <= fine + 1e-9, "coarser bins cancel more"


class TestOpenSet:
    @given(
        st.lists(st.integers(0, 5), min_size=1, max_size=20),
        st.lists(st.integers(0, 5), min_size=1, max_size=20),
    )
    def test_auroc_is_the_probability_of_the_correct_order(self, known, unknown):
        known, unknown = np.array(known, float), np.array(unknown, float)
        pairs = known[:, None] - unknown
        by_hand = (pairs > 0).mean() + (pairs == 0).mean() / 2
        assert area_under_curve(known, unknown) == pytest.approx(by_hand)

    def test_area_equals_scipy(self):
        rng = np.random.default_rng(0)
        known, unknown = rng.random(30) + 0.2, rng.random(20)
        expected = mannwhitneyu(known, unknown).statistic / 600
        assert area_under_curve(known, unknown) == pytest.approx(expected)

    def test_probability_takes_precedence_over_distance_as_open_set_measure(self):
        both = [answer(in_distribution_probability=0.9, distance=0.1)]
        assert open_set_scores(both) == ("in_distribution_probability", [0.9])
        near, far = answer(distance=0.1), answer("lamp", distance=0.7)
        found = crop_metrics([near, far], CLASSES)["open_set"]
        assert (found["measure"], found["auroc"], found["reason"]) == ("distance", 1.0, "")

    @pytest.mark.parametrize(
        ("answers", "reason"),
        [
            ([answer(distance=0.1)], "no objects of other kinds"),
            ([answer("lamp", distance=0.1)], "no objects of known classes"),
            ([answer(), answer("lamp")], "has no open-set measure"),
            ([answer(distance=0.1), answer("lamp")], "has no open-set measure"),
        ],
    )
    def test_undefined_metrics_have_a_reason(self, answers, reason):
        metrics = {**crop_metrics(answers, CLASSES), "command": ""}
        assert metrics["open_set"]["auroc"] is None
        assert reason in metrics["open_set"]["reason"]
        assert reason in report_of(metrics).replace("\n", " ")


def test_what_counts_as_an_error():
    assert not answer("chair").is_error
    assert answer("bed").is_error
    assert not answer("lamp", confident=False).is_error
    assert answer("lamp", confident=True).is_error
    assert not answer("armchair", use=LabelUse.LEFT_OUT, confident=True).is_error


def test_long_commands_can_be_copied():
    command = "circumspect evaluate --data " + " ".join(f"room-{k}.npz" for k in range(20))
    block = command_block(command)
    assert max(map(len, block.splitlines())) <= 80
    joined = block.removeprefix("```sh\n").removesuffix("\n```").replace("\\\n  ", "")
    assert joined == command


def test_many_classes_are_listed_in_place_of_a_table():
    classes = [f"class_{k}" for k in range(30)]
    p = dict.fromkeys(classes, 1 / 30)
    wrong = CropAnswer(
        source="file", scene="a|b`c\nd", name="0", label="class_1", use=LabelUse.KNOWN_CLASS,
        true_class="class_1", answer="class_0", probabilities=p, confident=False, reason="",
        in_distribution=True, in_distribution_probability=None, distance=None, alternatives={},
    )  # fmt: skip
    text = report_of({**crop_metrics([wrong] * 7, classes), "command": ""})
    assert "| class_1 | class_0 |       7 |" in text
    assert max(map(len, text.splitlines())) <= 80


@given(st.text(max_size=60), st.integers(5, 30))
def test_shortened_names_fit_and_break_no_table(text, width):
    short = shortened(text, width)
    assert len(short) <= width
    assert short.isprintable()
    assert not set("|`") & set(short)
