from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circumspect.classification import (
    Classifier,
    GridSpec,
    OnnxClassifier,
    Prediction,
    cell_evidence,
)
from circumspect.classification.evidence import log_odds, occupied_blocks
from circumspect.errors import GeometryError, InputError
from circumspect.furniture import make_furniture
from circumspect.grid import CylindricalGrid, OccupancyGrid, RectangularGrid

COARSE = (0.5,)


@pytest.fixture(scope="module")
def classifier():
    return Classifier.load("modelnet10", threads=1)


@pytest.fixture(scope="module")
def cloud():
    return make_furniture("chair", 3).sampled(20_000, 0)


@pytest.fixture(scope="module")
def grid(classifier, cloud):
    return classifier.input_spec.bounds(cloud).hits(cloud)


@pytest.fixture(scope="module")
def explained(classifier, grid):
    return cell_evidence(classifier, grid, edges=COARSE)


def rolled(grid, cells):
    return OccupancyGrid(grid.grid, np.roll(grid.states, cells, axis=1))


def test_evidence_explains_the_given_answer(classifier, grid, explained):
    assert explained.label == explained.prediction.label == classifier.classify_grid(grid).label
    p = explained.prediction.probability
    assert explained.log_odds == pytest.approx(np.log(p / (1 - p)))
    assert explained.cells.shape == grid.grid.shape
    assert not explained.cells.flags.writeable


class Recorded:
    """A classifier of states, size and visibility that records its inputs."""

    input_spec = GridSpec(visibility=True, metric=True)
    classes = ("a", "b")

    def __init__(self):
        self.inputs, self.contexts = [], []

    def classify_grid(self, grid, *, metric):
        self.metric = metric
        return Prediction("a", 0.6, {"a": 0.6, "b": 0.4})

    def scores(self, inputs, contexts):
        self.inputs.append(inputs)
        self.contexts.append(contexts)
        filled = (inputs == 2).reshape(len(inputs), -1).sum(axis=1)
        return np.stack([filled / 100.0, np.zeros(len(inputs))], axis=1)


@pytest.mark.parametrize("traced", [True, False])
def test_emptied_cells_are_free_where_rays_were_traced_and_else_unknown(grid, traced):
    states = np.where(grid.occupied, 2, 1 if traced else 0).astype(np.uint8)
    states[0] = 0
    recorded = Recorded()
    found = cell_evidence(recorded, OccupancyGrid(grid.grid, states), edges=(1.0,), metric=True)
    first, *emptied = np.concatenate(recorded.inputs)[:, 0, 0]
    np.testing.assert_array_equal(first, states)
    for shown in emptied:
        changed = shown != states
        assert changed.any()
        assert (states[changed] == 2).all()
        assert (shown[changed] == (1 if traced else 0)).all()
    assert (found.cells[states == 2] > 0).all()


@pytest.mark.parametrize("metric", [True, False])
def test_the_size_shown_stays_that_of_the_whole_object(grid, metric):
    recorded = Recorded()
    cell_evidence(recorded, grid, edges=(1.0,), metric=metric)
    contexts = np.concatenate(recorded.contexts)
    assert recorded.metric is metric
    assert len(np.unique(contexts, axis=0)) == 1
    assert contexts[0, 1] == metric
    assert (contexts[0, 2:] != 0).any() == metric


def test_empty_cells_have_no_evidence(grid, explained):
    assert (explained.cells[~grid.occupied] == 0).all()
    assert (explained.cells[grid.occupied] != 0).mean() > 0.9


@pytest.mark.parametrize("cells", [1, 13])
def test_evidence_turns_with_the_object(classifier, grid, explained, cells):
    turned = cell_evidence(classifier, rolled(grid, cells), edges=COARSE)
    assert turned.label == explained.label
    np.testing.assert_allclose(turned.cells, np.roll(explained.cells, cells, axis=1), atol=1e-4)


@settings(max_examples=25)
@given(
    edge=st.floats(0.05, 2.0),
    shape=st.tuples(st.integers(1, 9), st.integers(1, 9), st.integers(1, 9)),
    seed=st.integers(0, 99),
    height=st.floats(0.2, 3.0),
)
def test_every_occupied_cell_lies_in_a_block_and_blocks_turn(edge, shape, seed, height):
    states = (2 * (np.random.default_rng(seed).random(shape) < 0.3)).astype(np.uint8)
    for bounds in (CylindricalGrid(shape, 1.0, height), RectangularGrid(shape)):
        grid = OccupancyGrid(bounds, states)
        covered = np.zeros(shape, int)
        for block in occupied_blocks(grid, edge):
            covered[block.cells] += 1
        assert (covered[grid.occupied] > 0).all()
        if isinstance(bounds, CylindricalGrid):
            again = np.zeros(shape, int)
            for block in occupied_blocks(rolled(grid, 1), edge):
                again[block.cells] += 1
            np.testing.assert_array_equal(again, np.roll(covered, 1, axis=1))


def test_the_cells_of_most_evidence_carry_the_answer(classifier, grid, explained):
    """The deletion curve: without the strongest tenths the answer falls sooner than without any."""
    cells = np.argwhere(grid.occupied)
    strongest = cells[np.argsort(-explained.cells[grid.occupied], kind="stable")]
    drawn = np.random.default_rng(0).permutation(cells)
    column = classifier.classes.index(explained.label)

    def left(order, share):
        occupied = grid.occupied.copy()
        occupied[tuple(order[: int(share * len(order))].T)] = False
        inputs = occupied.astype(np.uint8)[None, None, None]
        return log_odds(classifier.scores(inputs))[0, column]

    shares = (0.1, 0.2, 0.3)
    assert np.mean([left(drawn, share) - left(strongest, share) for share in shares]) > 0.5


def test_another_class_can_be_asked_about(classifier, grid, explained):
    sofa = cell_evidence(classifier, grid, "sofa", COARSE)
    assert sofa.label == "sofa"
    assert sofa.log_odds < 0 < explained.log_odds
    with pytest.raises(InputError, match=r"no class 'stool'; known: bathtub"):
        cell_evidence(classifier, grid, "stool")


def test_points_take_the_evidence_of_their_cells(cloud, explained):
    values = explained.at(cloud)
    assert values.shape == (len(cloud),)
    assert np.isin(values, explained.cells).all()
    assert explained.at([[100.0, 0.0, 0.0]]).tolist() == [0.0]
    with pytest.raises(GeometryError):
        explained.at([[np.nan, 0.0, 0.0]])


def test_progress_ends_at_the_total(classifier, grid):
    calls = []
    found = cell_evidence(classifier, grid, edges=(1.0,), progress=lambda *c: calls.append(c))
    assert calls[-1] == (found.grid_count, found.grid_count)


@pytest.mark.parametrize("edges", [(), (0.0,), (-1.0,), (2.5,), (float("nan"),)])
def test_edges_out_of_range(classifier, grid, edges):
    with pytest.raises(InputError):
        cell_evidence(classifier, grid, edges=edges)


def test_grids_that_can_not_be_explained(classifier):
    with pytest.raises(InputError, match="the grid is empty"):
        cell_evidence(classifier, OccupancyGrid(CylindricalGrid(), np.zeros((32,) * 3, np.uint8)))
    with pytest.raises(InputError, match="expects cylindrical"):
        cell_evidence(classifier, RectangularGrid().hits(np.zeros((1, 3))))


def test_log_odds_do_not_saturate():
    scores = np.array([[400.0, 0.0, -3.0], [1.0, 1.0, 1.0]])
    odds = log_odds(scores)
    assert odds[0, 0] == pytest.approx(400 - np.log1p(np.exp(-3.0)))
    np.testing.assert_allclose(odds[1], -np.log(2))


def test_a_rectangular_input_spec_is_explained_as_well():
    class CornerCount:
        """A network that scores a chair by the number of occupied cells in one corner."""

        def get_inputs(self):
            return [SimpleNamespace(name="cells")]

        def get_outputs(self):
            return [SimpleNamespace(name="logits")]

        def run(self, names, feed):
            corner = feed["cells"][:, 0, :4, :4, :4].sum(axis=(1, 2, 3))
            return [np.stack([corner, np.zeros_like(corner)], axis=1, dtype=np.float32)]

    input_spec = GridSpec(kind="rectangular", shape=(8, 8, 8))
    description = {"classes": ["chair", "sofa"], "grid": input_spec.to_dict()}
    classifier = OnnxClassifier(CornerCount(), description)
    states = np.full((8, 8, 8), 2, np.uint8)
    found = cell_evidence(
        classifier, OccupancyGrid(RectangularGrid((8, 8, 8)), states), edges=(1.0,)
    )
    np.testing.assert_allclose(found.cells[:4, :4, :4], 64.0, rtol=1e-4)
    assert np.abs(found.cells[4:]).max() == 0
