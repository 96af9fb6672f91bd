import json
import os
import re
import stat
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from network_inputs import small_input_spec, some_inputs, trained_looking
from safetensors.torch import save_file

from circumspect.classification import GridSpec, PointsSpec
from circumspect.errors import InputError, WeightsError
from circumspect.nets import NETS, Checkpoint, build_net, cost_of
from circumspect.nets.azimuth import RowWisePool, wrap
from circumspect.nets.checkpoint import HEADER, save_tensors
from circumspect.nets.registry import require_takes

CLASSES = ("bed", "chair", "table")


def assert_yaw_invariant(net, grids, tolerance=1e-4):
    """Rolling the azimuth by any whole cells leaves the logits; reports the largest change."""
    with torch.no_grad():
        reference = net(grids)
        changes = [
            float((net(grids.roll(cells, dims=3)) - reference).abs().max())
            for cells in range(1, grids.shape[3])
        ]
    assert max(changes) < tolerance, f"logits move by {max(changes):.2g} when the grid is rolled"
    assert reference.std(0).max() > 10 * tolerance, "the network answers the same to everything"


@pytest.mark.parametrize("name", [name for name, spec in NETS.items() if spec.whole_cells])
def test_answers_are_invariant_to_whole_cells(name):
    assert_yaw_invariant(trained_looking(name), some_inputs(NETS[name].input_spec, 4, seed=1))


@pytest.mark.parametrize("name", NETS)
def test_all_weights_learn(name):
    input_spec = small_input_spec(name)
    net = trained_looking(name).train()
    reported = net(some_inputs(input_spec, 4))
    logits = getattr(reported, "logits", reported)
    assert logits.shape == (4, 3)
    loss = sum(
        (part**2).sum() for part in (reported if isinstance(reported, tuple) else (reported,))
    )
    loss.backward()
    for key, parameter in net.named_parameters():
        assert parameter.grad is not None, key
        assert parameter.grad.isfinite().all(), key
        assert parameter.ndim == 1 or parameter.grad.abs().sum() > 0, key


def test_inputs_that_a_network_does_not_take_are_refused():
    with pytest.raises(InputError, match="pointnet takes points"):
        build_net("pointnet", 10, GridSpec())
    with pytest.raises(InputError, match="planes takes grids"):
        build_net("planes", 10, PointsSpec())


GRID_NETS = [name for name, spec in NETS.items() if isinstance(spec.input_spec, GridSpec)]


def builds(name, *shape):
    try:
        require_takes(name, GridSpec(NETS[name].input_spec.kind, shape))
    except InputError:
        return False
    return True


@pytest.mark.parametrize("name", GRID_NETS)
def test_the_stated_minimum_of_cells_is_the_smallest_accepted(name):
    with pytest.raises(InputError) as refused:
        build_net(name, 3, GridSpec(NETS[name].input_spec.kind, (1, 1, 1)))
    if name.endswith("planes"):
        reported = re.search(r"multiples of (\d+) and more than (\d+) azimuths", str(refused.value))
        rows, azimuths = int(reported[1]), int(reported[2])
        least = (rows, azimuths + 1, rows)
        for cells in range(1, 3 * rows):
            assert builds(name, cells, 32, 32) == builds(name, 32, 32, cells) == (cells % rows == 0)
            assert builds(name, 32, cells, 32) == (cells > azimuths)
    else:
        needed = int(re.search(r"needs (\d+) cells or more", str(refused.value))[1])
        least = (needed,) * 3
        for cells in range(1, needed + 3):
            for axis in range(3):
                shape = [needed] * 3
                shape[axis] = cells
                assert builds(name, *shape) == (cells >= needed)
    input_spec = GridSpec(NETS[name].input_spec.kind, least)
    with torch.no_grad():
        assert build_net(name, 3, input_spec).eval()(some_inputs(input_spec, 2)).shape == (2, 3)


@pytest.mark.parametrize("name", NETS)
def test_asking_for_the_inputs_of_a_network_draws_no_random_numbers(name):
    before = torch.get_rng_state()
    require_takes(name, NETS[name].input_spec)
    assert torch.equal(torch.get_rng_state(), before)


@given(margin=st.integers(0, 5), roll=st.integers(-7, 7))
def test_wrapping_continues_the_circle(margin, roll):
    circle = torch.arange(6.0).reshape(1, 1, 6)
    wrapped = wrap(circle.roll(roll, 2), margin, 2)[0, 0].numpy()
    expected = np.roll(np.arange(6.0), roll)[np.arange(-margin, 6 + margin) % 6]
    np.testing.assert_array_equal(wrapped, expected)


def test_row_wise_pool_is_max_and_mean():
    features = torch.randn(2, 3, 5)
    pooled = RowWisePool()(features)
    torch.testing.assert_close(pooled, torch.cat([features.amax(2), features.mean(2)], 1))


def test_our_network_is_small():
    cost = cost_of(build_net("planes", 10, GridSpec()), (1, 32, 32, 32))
    assert cost.parameters <= 2_000_000
    assert cost.multiply_adds < 460_000_000


def test_cost_counts_a_known_layer():
    layer = torch.nn.Sequential(torch.nn.Conv3d(1, 16, 3))
    cost = cost_of(layer, (1, 32, 32, 32))
    assert cost.parameters == 448
    assert cost.multiply_adds == 30**3 * 27 * 16


def test_the_heading_turns_with_the_object():
    net = trained_looking("headed-planes")
    grids = some_inputs(GridSpec(), 2, seed=2)
    with torch.no_grad():
        assert isinstance(net(grids), torch.Tensor)
        columns = net.columns(grids)
        turned = net.columns(grids.roll(5, dims=3))
        torch.testing.assert_close(turned, columns.roll(5, dims=2), atol=1e-4, rtol=1e-4)
        reported = net.train()(grids)
    assert reported.logits.shape == (2, 3)
    assert reported.heading.shape == (2, 32)


def test_a_committee_of_three_headed_networks_fits_the_budget_of_a_robot():
    cost = cost_of(build_net("headed-planes", 10, GridSpec()), (1, 32, 32, 32))
    assert 3 * cost.parameters <= 2_000_000


def test_unknown_net_is_named_with_a_near_one():
    with pytest.raises(InputError, match="did you mean planes"):
        build_net("plannes", 10, GridSpec())


class TestCheckpoint:
    def checkpoint(self):
        net = trained_looking("planes")
        input_spec = GridSpec()
        return Checkpoint("planes", CLASSES, input_spec, net.state_dict(), {"seed": 3})

    def test_round_trip(self, tmp_path):
        original = self.checkpoint()
        original.save(tmp_path / "w.safetensors")
        back = Checkpoint.load(tmp_path / "w.safetensors")
        assert (back.net, back.classes, back.input_spec) == ("planes", CLASSES, GridSpec())
        assert back.training == {"seed": 3}
        grids = torch.rand(2, 1, 32, 32, 32)
        torch.testing.assert_close(back.build()(grids), original.build()(grids))

    def test_header_with_the_earlier_name_of_dithered_is_read(self, tmp_path):
        net = trained_looking("planes")
        grid = GridSpec().to_dict()
        grid["staggered"] = grid.pop("dithered")
        header = {"net": "planes", "classes": list(CLASSES), "grid": grid, "training": {}}
        save_tensors(tmp_path / "w.st", net.state_dict(), {HEADER: json.dumps(header)})
        assert Checkpoint.load(tmp_path / "w.st").input_spec == GridSpec()

    def test_permissions_are_those_of_any_new_file(self, tmp_path):
        mask = os.umask(0o027)
        try:
            self.checkpoint().save(tmp_path / "w.safetensors")
        finally:
            os.umask(mask)
        assert stat.S_IMODE((tmp_path / "w.safetensors").stat().st_mode) == 0o640

    def test_broken_files_are_named(self, tmp_path):
        path = tmp_path / "w.safetensors"
        with pytest.raises(WeightsError, match="no such file"):
            Checkpoint.load(path)
        self.checkpoint().save(path)
        whole = path.read_bytes()
        for broken in (b"", whole[:100], whole[:-100], b"\xff" * 64):
            path.write_bytes(broken)
            with pytest.raises(WeightsError, match="not a checkpoint"):
                Checkpoint.load(path)

    def test_mutated_files_load_or_are_named(self, tmp_path):
        path = tmp_path / "w.safetensors"
        self.checkpoint().save(path)
        whole = path.read_bytes()
        rng = np.random.default_rng(0)
        for _ in range(60):
            content = bytearray(whole)
            for place in rng.integers(0, 6000, 8):
                content[place] = rng.integers(256)
            path.write_bytes(content)
            with suppress(WeightsError, InputError):
                Checkpoint.load(path).build()

    def test_weights_of_another_program(self, tmp_path):
        path = tmp_path / "w.safetensors"
        save_file({"a": torch.zeros(3)}, path)
        with pytest.raises(WeightsError, match="not a checkpoint"):
            Checkpoint.load(path)
        save_file({"a": torch.zeros(3)}, path, {"circumspect": json.dumps({"net": "planes"})})
        with pytest.raises(WeightsError, match="not a checkpoint"):
            Checkpoint.load(path)

    def test_weights_that_are_not_finite_are_refused(self, tmp_path):
        path, original = tmp_path / "w.safetensors", self.checkpoint()
        name = next(iter(original.weights))
        original.weights[name].fill_(torch.nan)
        original.save(path)
        with pytest.raises(WeightsError, match=f"{name} holds numbers that are not finite"):
            Checkpoint.load(path)

    def test_weights_of_another_number_of_classes_are_refused(self):
        original = self.checkpoint()
        wrong = Checkpoint("planes", ("a", "b"), original.input_spec, original.weights)
        with pytest.raises(WeightsError, match="do not fit"):
            wrong.build()

    @pytest.mark.parametrize(
        ("entry", "value"),
        [
            ("net", []), ("net", 3), ("classes", "abc"), ("classes", [1, 2, 3]),
            ("classes", ["a", "a", "b"]), ("classes", 3), ("grid", [1]), ("grid", "cylindrical"),
            ("grid", {"kind": []}),
            ("grid", {"shape": [1000, 1000, 1000]}), ("training", [1]), ("training", 3),
            ("training", {"settings": [1]}), ("training", {"reached": 1}),
            ("training", {"objects": "chair"}), ("training", {"objects": [1]}),
        ],
    )  # fmt: skip
    def test_headers_of_other_types(self, tmp_path, entry, value):
        path = tmp_path / "w.safetensors"
        header = {
            "net": "planes", "classes": list(CLASSES), "grid": GridSpec().to_dict(),
            "training": {},
        }  # fmt: skip
        save_file({"a": torch.zeros(3)}, path, {"circumspect": json.dumps(header)})
        assert Checkpoint.load(path).classes == CLASSES
        save_file(
            {"a": torch.zeros(3)}, path, {"circumspect": json.dumps({**header, entry: value})}
        )
        with pytest.raises(WeightsError, match="not a checkpoint"):
            Checkpoint.load(path)

    def test_tensors_of_four_bits(self, tmp_path):
        path = tmp_path / "w.safetensors"
        header = {
            "net": "planes", "classes": list(CLASSES), "grid": GridSpec().to_dict(),
            "training": {},
        }  # fmt: skip
        content = json.dumps(
            {
                "__metadata__": {"circumspect": json.dumps(header)},
                "w": {"dtype": "F4", "shape": [2], "data_offsets": [0, 1]},
            }
        ).encode()
        path.write_bytes(len(content).to_bytes(8, "little") + content + b"\0")
        with pytest.raises(WeightsError, match="not a checkpoint"):
            Checkpoint.load(path)

    @pytest.mark.parametrize("name", NETS)
    def test_a_network_of_the_described_size_is_not_allocated(self, name, monkeypatch):
        """A header of a few kilobytes could describe gigabytes of weights."""
        built = []
        monkeypatch.setattr(
            "circumspect.nets.checkpoint.build_net",
            lambda *wanted: built.append(torch.empty(0).device.type) or build_net(*wanted),
        )
        input_spec = NETS[name].input_spec
        if isinstance(input_spec, GridSpec):
            input_spec = replace(input_spec, shape=(128, 128, 128))
        classes = tuple(f"class {n}" for n in range(1000))
        with pytest.raises(WeightsError, match="do not fit"):
            Checkpoint(name, classes, input_spec, {"a": torch.zeros(3)}).build()
        assert built == ["meta"]
