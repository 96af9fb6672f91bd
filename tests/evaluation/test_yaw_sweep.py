import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from two_kinds import ByHeight, flat_and_tall

from circumspect.datasets import ObjectSet
from circumspect.errors import InputError, WeightsError
from circumspect.evaluation.accuracy import confusion_matrix, mean_class_accuracy
from circumspect.evaluation.figures import draw_all, draw_probable_errors, save_figure
from circumspect.evaluation.yaw_sweep import YawSweep, spread_yaws, sweep_yaw


class ByDirection(ByHeight):
    """Not invariant: looks at what lies towards +x."""

    def probabilities(self, grids):
        towards = grids[:, :, 0, 16:, :4].any(axis=(1, 2, 3, 4)).astype(float)
        return np.stack([1 - towards, towards], axis=1)


def test_an_invariant_predictor_has_no_spread():
    sweep = sweep_yaw(ByHeight(), flat_and_tall(12), spread_yaws(7))
    metrics = sweep.to_dict()
    assert metrics["accuracy"] == [1.0] * 7
    assert metrics["mean_class_accuracy"] == [1.0] * 7
    assert (metrics["worst"], metrics["spread"], metrics["flip_rate"]) == (1.0, 0.0, 0.0)
    assert metrics["confusion"] == [[42, 0], [0, 42]]
    assert metrics["objects"] == 12
    assert set(metrics["milliseconds"]) == {"grid", "classify"}
    json.dumps(metrics)


def test_a_predictor_that_depends_on_yaw_has_a_spread():
    sweep = sweep_yaw(ByDirection(), flat_and_tall(12), spread_yaws(16))
    assert sweep.flip_rate > 0.4
    assert sweep.to_dict()["spread"] > 0.2


def test_figures_are_written(tmp_path):
    from PIL import Image

    sweep = sweep_yaw(ByDirection(), flat_and_tall(12), spread_yaws(8))
    files = draw_all(sweep, flat_and_tall(12), tmp_path)
    assert len(files) == 4
    for file in files:
        with Image.open(file) as picture:
            assert min(picture.size) > 500
            assert len(picture.convert("L").getcolors()) > 20


def test_names_that_are_no_text_are_drawn(tmp_path):
    objects = flat_and_tall(12)
    named = np.array([f"{name}\udcff" for name in objects.names])
    strange = ObjectSet(objects.points_xyz, objects.labels, named, objects.classes)
    sweep = sweep_yaw(ByDirection(), strange, spread_yaws(4))
    save_figure(draw_probable_errors(sweep, strange), tmp_path / "mistakes.png")


def test_other_classes_are_refused():
    other = flat_and_tall(12)
    renamed = ObjectSet(other.points_xyz, other.labels, other.names, ("a", "b"))
    with pytest.raises(WeightsError, match="know flat, tall, but the data set has a, b"):
        sweep_yaw(ByHeight(), renamed, [0.0])
    with pytest.raises(InputError, match="nothing to evaluate"):
        sweep_yaw(ByHeight(), flat_and_tall(12), [])


@given(count=st.integers(2, 200), cells=st.sampled_from([16, 32, 64]))
def test_yaws_cover_the_turn_and_all_fractions_of_a_cell(count, cells):
    yaws = np.array(spread_yaws(count))
    assert yaws[0] == 0
    assert (np.floor(yaws * count / 360 + 1e-9) == np.arange(count)).all()
    fractions = np.sort(yaws % (360 / cells)) / (360 / cells)
    assert len(np.unique(np.round(fractions, 9))) == count
    with pytest.raises(InputError, match="at least one"):
        spread_yaws(0)


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3)), min_size=1, max_size=60))
def test_accuracy_measures_agree_with_their_definitions(pairs):
    labels, answers = np.array(pairs).T
    confusion = confusion_matrix(labels, answers, 4)
    assert confusion.sum() == len(pairs)
    assert np.trace(confusion) == (labels == answers).sum()
    by_hand = [np.mean(answers[labels == c] == c) for c in range(4) if (labels == c).any()]
    assert mean_class_accuracy(labels == answers, labels, 4) == pytest.approx(np.mean(by_hand))


def test_a_sweep_round_trips(tmp_path):
    sweep = sweep_yaw(ByDirection(), flat_and_tall(12), spread_yaws(3))
    sweep.save(tmp_path / "sweep.npz")
    back = YawSweep.load(tmp_path / "sweep.npz")
    assert back.to_dict() == sweep.to_dict()
    content = (tmp_path / "sweep.npz").read_bytes()
    for broken in (b"", content[:100], content[:-40]):
        (tmp_path / "sweep.npz").write_bytes(broken)
        with pytest.raises(InputError, match=r"sweep\.npz"):
            YawSweep.load(tmp_path / "sweep.npz")
