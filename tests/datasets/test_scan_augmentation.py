"""Simulated scans: what is seen lies on the object, and chance is repeatable."""

from dataclasses import asdict

import numpy as np
import pytest
from scipy.spatial import cKDTree

from circumspect.classification import GridSpec, PointsSpec
from circumspect.classification.context import LOG_HEIGHT, SCALE_KNOWN, VISIBILITY_KNOWN
from circumspect.datasets.labelled_surfaces import OTHER
from circumspect.datasets.object_caster import ObjectCaster
from circumspect.datasets.scan_augmentation import MIN_VOXELS, ScanAugmentation
from circumspect.datasets.scan_sources import of_point_set, procedural
from circumspect.datasets.scanned_inputs import (
    azimuth_coverage,
    drawn_cylinder,
    scanned_inputs,
    traced,
)
from circumspect.errors import InputError
from circumspect.furniture import make_furniture
from circumspect.grid.grid import FREE, OCCUPIED, UNKNOWN
from circumspect.recognition.object_grids import azimuth_coverage as coverage_in_recognition

CLEAN = ScanAugmentation(
    mirror=0.0, stretch=0.0, resize=0.0, complete=0.0, occluded=0.0, beside=0.0, cluttered=0.0,
    walled=0.0, rescale=0.0, furnished=0.0, merged=0.0, thinned=0.0,
    leak=0.0, boxed=0.0, cut=0.0, lowered=0.0, strays=0.0, registration=0.0, floor_cut=(0.02, 0.02),
)  # fmt: skip

SEEING = GridSpec(margin=1.1, visibility=True, metric=True)


def scan_of(category="chair", settings=CLEAN, seed=0):
    mesh = make_furniture(category, 3)
    return mesh, settings.scan(ObjectCaster(mesh), np.random.default_rng(seed))


@pytest.mark.parametrize("seed", range(4))
def test_a_clean_scan_lies_on_the_object(seed):
    mesh, scan = scan_of(seed=seed)
    apart, _ = cKDTree(mesh.sampled(60_000).points_xyz).query(scan.points_xyz)
    assert len(scan.points_xyz) >= MIN_VOXELS
    # The sensor's noise, its lateral error at edges, and the samples' spacing.
    assert np.quantile(apart, 0.9) < 0.03


def test_a_single_view_misses_the_far_side():
    settings = ScanAugmentation(**{**vars(CLEAN), "single": 1.0})
    mesh, scan = scan_of("dresser", settings)
    assert len(scan.views_xyz) == 1
    view = scan.views_xyz[0, :2]
    forward = -view / np.linalg.norm(view)
    # Seen from one side, a closed box shows nothing of its back.
    depth = scan.points_xyz[:, :2] @ forward
    whole = mesh.vertices_xyz[:, :2] @ forward
    upright = scan.points_xyz[:, 2] < 0.8 * mesh.vertices_xyz[:, 2].max()
    assert depth[upright].max() < whole.max() - 0.05


def test_objects_of_unknown_unit_take_other_sizes_of_their_class():
    caster = ObjectCaster(make_furniture("table", 3))
    settings = ScanAugmentation(**{**vars(CLEAN), "complete": 1.0, "rescale": 1.0})
    height = np.ptp(caster.corners_xyz, axis=0)[2]
    factors = [
        np.ptp(settings.scan(caster, np.random.default_rng(seed), (0.5, 2.0)).points_xyz[:, 2])
        / height
        for seed in range(30)
    ]
    assert 0.45 < min(factors) < 0.7
    assert 1.5 < max(factors) < 2.1
    fixed = settings.scan(caster, np.random.default_rng(0)).points_xyz
    assert np.ptp(fixed[:, 2]) == pytest.approx(height, rel=0.1)


def test_strong_augmentation_still_gives_scans():
    rough = ScanAugmentation(
        occluded=1.0, walled=1.0, beside=1.0, cluttered=1.0, cut=1.0, strays=1.0,
        furnished=1.0, merged=1.0, thinned=1.0,
    )  # fmt: skip
    for seed in range(6):
        _, scan = scan_of("sofa", rough, seed)
        assert np.isfinite(scan.points_xyz).all()
        assert np.isfinite(scan.ends_xyz).all()


def test_the_same_seed_gives_the_same_scan():
    (_, first), (_, second) = (
        scan_of(settings=ScanAugmentation()),
        scan_of(settings=ScanAugmentation()),
    )
    np.testing.assert_array_equal(first.points_xyz, second.points_xyz)


@pytest.mark.parametrize("name", ["mirror", "single", "cut", "complete"])
def test_chances_out_of_range_are_refused(name):
    with pytest.raises(InputError, match=name):
        ScanAugmentation(**{name: 1.5})


def test_missing_settings_of_older_documents_are_off():
    document = asdict(ScanAugmentation())
    assert ScanAugmentation.from_dict(document) == ScanAugmentation()
    for name in ("rescale", "furnished", "merged", "thinned"):
        del document[name]
    old = ScanAugmentation.from_dict(document)
    assert (old.rescale, old.furnished, old.merged, old.thinned) == (0, 0, 0, 0)
    assert old.beside == ScanAugmentation().beside


def test_coverage_is_that_of_the_pipeline():
    _, scan = scan_of(seed=2)
    grid = traced(scan, drawn_cylinder(scan, np.random.default_rng(0)))
    expected = coverage_in_recognition(scan.views_xyz, grid)
    assert azimuth_coverage(scan.views_xyz, grid.grid.centre_xyz) == pytest.approx(
        expected, abs=0.03
    )


def test_scanned_inputs_are_cached_and_hold_three_states(tmp_path):
    objects = procedural(1, 1, held_back=True)
    objects = objects.subset(np.isin(objects.labels, ["chair", OTHER]) & (np.arange(23) < 14))
    calls = []

    def made():
        return scanned_inputs(
            objects, ScanAugmentation(), 2, 0, SEEING, folder=tmp_path, workers=1,
            progress=lambda done, total: calls.append((done, total)),
        )  # fmt: skip

    first, again = made(), made()
    assert calls == [(len(objects), len(objects))]  # The second time nothing is made.
    np.testing.assert_array_equal(first.packed, again.packed)
    states = first.inputs(np.zeros(2, int), np.arange(2))
    assert set(np.unique(states)) <= {UNKNOWN, FREE, OCCUPIED}
    assert (first.context[..., SCALE_KNOWN] == 1).all()
    scans = first.context[..., VISIBILITY_KNOWN] == 1
    assert np.isfinite(first.coverage[scans]).all()
    assert np.isnan(first.coverage[~scans]).all()
    assert (np.exp(first.context[..., LOG_HEIGHT]) < 3).all()


def test_a_broken_part_of_the_cache_is_made_again(tmp_path):
    objects = procedural(1, 0, held_back=True)
    objects = objects.subset(objects.labels == "chair")
    first = scanned_inputs(objects, ScanAugmentation(), 1, 0, SEEING, folder=tmp_path, workers=1)
    for path in tmp_path.iterdir():
        path.write_bytes(path.read_bytes()[:100])
    again = scanned_inputs(objects, ScanAugmentation(), 1, 0, SEEING, folder=tmp_path, workers=1)
    np.testing.assert_array_equal(first.packed, again.packed)


def test_classes_without_a_known_size_are_refused():
    from tests.two_kinds import two_kinds

    with pytest.raises(InputError, match="no sizes are known for plate, post"):
        of_point_set(two_kinds())


@pytest.mark.parametrize("input_spec", [PointsSpec(64), GridSpec("rectangular", (8, 8, 8))])
def test_networks_without_a_context_are_shown_points_or_occupied_cells(tmp_path, input_spec):
    objects = procedural(1, 0, held_back=True)
    objects = objects.subset(objects.labels == "chair")
    found = scanned_inputs(objects, CLEAN, 2, 0, input_spec, folder=tmp_path, workers=1)
    shown = found.inputs(np.zeros(2, int), np.arange(2))
    assert shown.shape == (2, *input_spec.input_shape)
    assert np.isfinite(shown).all()
    assert (np.abs(shown) <= 1.2).all()
    assert len(np.unique(shown)) > 1
