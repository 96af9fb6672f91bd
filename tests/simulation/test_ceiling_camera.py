"""The tag detector on simulated images, and on faulty ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from ceiling_room import ASIDE, FAR, MOUNT, SIZE, hung, truth
from scipy.spatial.transform import RigidTransform, Rotation

from circumspect.errors import InputError
from circumspect.geometry import PinholeCamera, PlanarPose
from circumspect.localization import (
    BRIDGED,
    TRACKED,
    CharucoBoard,
    FixedCamera,
    IntelligentSpace,
    LensCamera,
    TagDetector,
    TagMount,
    calibrate_extrinsics,
    calibrate_lens,
)
from circumspect.localization.tag_observer import TagObserver
from circumspect.simulation import (
    CeilingCamera,
    CeilingOptics,
    CeilingRig,
    PlacedPlate,
    Plate,
    RayCaster,
    Scene,
    TrueState,
    block,
    board_images,
    ceiling_cameras,
    displaced,
    surveyed_tags,
)


@pytest.fixture(scope="module")
def caster():
    return RayCaster(Scene.with_object(FAR))


def test_the_tag_is_found_where_it_is(rig, pair):
    rng, errors, missed = np.random.default_rng(0), [], 0
    watches = {camera.name: TagObserver(camera, MOUNT) for camera in pair}
    for n in range(12):
        x, y, yaw = rng.uniform([-0.7, -0.6, -3], [0.7, 0.6, 3])
        for image in rig.images(truth(x, y, yaw, n)):
            pose = watches[image.camera].look(image).pose
            if pose is None:
                missed += 1
                continue
            turn = (pose.T_map_base.yaw - yaw + np.pi) % (2 * np.pi) - np.pi
            errors.append([*(pose.T_map_base.xy - [x, y]), turn])
    errors = np.array(errors)
    assert missed <= 2
    # A pixel is 6 mm here: less than a twelfth of it.
    assert np.linalg.norm(errors[:, :2], axis=1).max() < 3e-3
    assert np.abs(np.degrees(errors[:, 2])).max() < 0.5
    assert np.abs(errors.mean(axis=0)[:2]).max() < 5e-4


def test_the_same_seed_gives_the_same_images(caster):
    one, other, third = (
        CeilingCamera(hung(), caster, rng=seed).photograph(0.0).grey for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, other)
    assert (one != third).mean() > 0.5
    assert one.dtype == np.uint8
    assert one.shape == SIZE[::-1]


def test_images_have_uneven_light_noise_and_blur(caster):
    flat = CeilingOptics(blur=0, noise=0, gradient=0, vignetting=0)
    tag = (PlacedPlate(Plate.tag(3, 0.3), RigidTransform.identity()),)

    def image(**what):
        return CeilingCamera(hung(), caster, replace(flat, **what), 0).photograph(0, tag).grey

    plain = image().astype(float)
    assert image(noise=4.0).astype(float).std() > plain.std()
    assert image(gradient=0.5).mean() < plain.mean()
    assert image(vignetting=0.5)[0, 0] < plain[0, 0]
    edges = [np.abs(np.diff(picture.astype(float))).max() for picture in (plain, image(blur=2.0))]
    assert edges[1] < 0.7 * edges[0]


def test_edges_are_rendered_with_sub_pixel_accuracy(caster):
    """Coverage of pixels under a white plate, against its edge, at fractions of a pixel."""
    straight = FixedCamera(
        "s",
        LensCamera(PinholeCamera(64, 64, 100.0, 100.0, 31.5, 31.5)),
        RigidTransform.from_components([0, 0, 3.0], Rotation.from_euler("x", np.pi)),
    )
    ideal = CeilingOptics(0, 0, 0, 0, 0, 250)
    one = CeilingCamera(straight, caster, ideal, 0)
    plate = Plate(np.ones((1, 1), np.float32), 1.0, 1.0)
    empty = one.photograph(0.0).grey[32].astype(float)
    for shift in np.linspace(0, 0.029, 7):
        at = RigidTransform.from_components([0.5 + shift, 0, 1.0], Rotation.identity())
        row = one.photograph(0.0, (PlacedPlate(plate, at),)).grey[32].astype(float)
        share = (row - empty) / (250 - empty)
        # 50 px/m at this depth: the edge is at 31.5 + 50 shift.
        edge = 64 - 0.5 - share.sum()
        assert edge == pytest.approx(31.5 + 50 * shift, abs=1 / 32 + 0.02)


def test_walls_hide_the_tag(pair):
    wall = Scene.with_object(block((-0.5, -0.5, 1.0), (0.5, 0.5, 1.1)))
    rig = CeilingRig(pair[:1], wall, MOUNT)
    sighting = TagObserver(pair[0], MOUNT).look(rig.images(truth(-0.4))[0])
    assert sighting.reason == "the tag is not in view"


def test_a_tag_half_out_of_view_gives_no_pose(rig, pair):
    watch = TagObserver(pair[0], MOUNT)
    edge = pair[0].on_plane(np.array([[0.0, 240.0], [3.0, 240.0], [40.0, 240.0]]), MOUNT.height)
    tag = PlanarPose() @ MOUNT.T_base_tag.inverse()
    for n, (x, y) in enumerate(edge[:2]):
        sighting = watch.look(rig.images(truth(x + tag.x, y + tag.y, 0.0, n))[0])
        assert sighting.pose is None
        assert sighting.reason in ("the tag is not in view", "the tag is at the edge of the image")


def test_motion_blur_gives_no_wrong_pose(pair):
    """At 3 m/s and 40 ms the tag smears over half its width."""
    rig = CeilingRig(pair[:1], Scene.with_object(FAR), MOUNT, CeilingOptics(exposure=0.04))
    watch = TagObserver(pair[0], MOUNT)
    for speed, exact in ((0.2, 0.004), (3.0, None)):
        stamp = 10 * speed
        rig.images(truth(-0.4 - 0.1 * speed, 0.0, 0.2, stamp - 0.1))
        sighting = watch.look(rig.images(truth(-0.4, 0.0, 0.2, stamp))[0])
        if exact is not None:
            assert np.linalg.norm(sighting.pose.T_map_base.xy - [-0.4, 0]) < exact
        elif sighting.pose is not None:
            assert np.linalg.norm(sighting.pose.T_map_base.xy - [-0.4, 0]) < 0.02


def test_other_tags_are_reported_and_a_repeated_own_tag_is_ambiguous(rig, pair):
    watch = TagObserver(pair[0], MOUNT)
    other = CeilingRig(
        pair[:1], Scene.with_object(FAR), TagMount(7), CeilingOptics(exposure=0.0), 1
    )
    T = PlanarPose(-0.9, 0.4, 1.0).as_transform()
    first = watch.look(rig.images(truth(-0.4), other.robot([T]))[0])
    assert first.pose is not None
    assert first.others == (7,)
    only = watch.look(other.images(truth(-0.4, stamp=1.0))[0])
    assert only.full_reason == "the tag is not in view (unknown tags are: 7)"
    twice = watch.look(rig.images(truth(-0.4, stamp=2.0), rig.robot([T]))[0])
    assert twice.reason == "tag 3 is in the image 2 times: ambiguous"
    assert twice.pose is None


def test_a_tag_of_another_size_or_tilted_is_reported(rig, pair):
    small = TagObserver(pair[0], TagMount(3, 0.15, 0.30, MOUNT.T_base_tag))
    sighting = small.look(rig.images(truth(-0.3))[0])
    assert "not those of a level tag of 0.15 m" in sighting.reason
    lean = PlanarPose(-0.3).as_transform() * RigidTransform.from_rotation(
        Rotation.from_euler("x", 25, degrees=True)
    )
    watch = TagObserver(pair[0], MOUNT)
    assert "tilted" in watch.look(rig.images(TrueState(3.0, lean, lean))[0]).reason


def test_stale_late_frozen_and_foreign_images_are_skipped(rig, pair):
    space = IntelligentSpace(pair[:2], MOUNT)
    first = rig.images(truth(stamp=1.0))[:2]
    assert space.locate(first).state == TRACKED
    assert "stale" in space.locate(first).sightings[0].reason
    fresh = IntelligentSpace(pair[:2], MOUNT)
    fresh.locate(first[:1])
    assert "late" in fresh.locate([replace(first[1], stamp=0.9)]).sightings[0].reason
    frozen = space.locate([replace(first[0], stamp=1.2)])
    assert "frozen" in frozen.sightings[0].reason
    assert frozen.state == BRIDGED
    foreign = space.locate([replace(first[0], stamp=1.3, camera="z")])
    assert foreign.sightings[0].reason == "no calibration of this camera; known: a, b"
    cut = space.locate([replace(first[0], stamp=1.4, grey=first[0].grey[:, :600])])
    assert cut.sightings[0].reason == "the image has 600x480 pixels, the calibration 640x480"
    with pytest.raises(InputError):
        space.locate([])
    with pytest.raises(InputError, match="different names"):
        IntelligentSpace([pair[0], pair[0]])


def test_a_displaced_camera_is_detected(pair):
    after = (displaced(pair[0], ASIDE), *pair[1:])
    rig = CeilingRig(after, Scene.with_object(FAR), MOUNT, seed=2)
    space = IntelligentSpace(pair, MOUNT)
    fixes = [space.locate(rig.images(truth(0.01 * n, 0.1, 0.5, 0.1 * n))) for n in range(10)]
    assert all(fix.cameras == ("b", "c") for fix in fixes)
    assert np.linalg.norm(fixes[-1].T_map_base.xy - [0.09, 0.1]) < 3e-3
    (report,) = space.reports
    assert report.startswith("camera 'a' moved since calibration: it differs by ")


def test_the_number_of_workers_does_not_change_fixes(rig, pair):
    from circumspect.localization import SpaceSettings

    images = [rig.images(truth(0.02 * n, 0.1, 0.3 * n, 0.1 * n)) for n in range(5)]
    poses = []
    for workers in (1, 3):
        space = IntelligentSpace(pair, MOUNT, SpaceSettings(workers=workers))
        poses.append([space.locate(slot).T_map_base for slot in images])
    assert poses[0] == poses[1]


def test_images_of_a_board_and_of_tags_calibrate_a_camera(caster):
    true = hung()
    one = CeilingCamera(true, caster, rng=3)
    board = CharucoBoard()
    found = calibrate_lens(board_images(one, board, 14, 1), board)
    assert found.rms_px < 0.2
    assert found.coverage > 0.7
    assert found.lens.pinhole.fx == pytest.approx(true.lens.pinhole.fx, rel=2e-3)
    points = np.random.default_rng(0).uniform([-0.6, -0.45, 1], [0.6, 0.45, 1], (200, 3))
    assert np.abs(found.lens.project(points) - true.lens.project(points)).max() < 1.5
    survey, laid = surveyed_tags([-1.2, -0.9], [1.2, 0.9], 0.25, rng=1)
    tags = TagDetector(1.0).detect(one.photograph(0.0, laid).grey)
    place = calibrate_extrinsics("a", true.lens, [tags], survey).camera
    error = (true.T_map_camera.inv() * place.T_map_camera).as_exp_coords()
    assert np.linalg.norm(error[3:]) < 0.01
    assert error @ np.linalg.solve(place.covariance, error) < 30


@pytest.mark.parametrize("count", [1, 2, 3, 4, 6])
def test_ceiling_cameras_see_the_whole_floor(count):
    low, high = np.array([-1.2, -0.9]), np.array([1.2, 0.9])
    cameras = ceiling_cameras(low, high, count, seed=2)
    assert len({camera.name for camera in cameras}) == count
    places = np.random.default_rng(0).uniform(low, high, (200, 2))
    seen = np.zeros(200, bool)
    for camera in cameras:
        pixels = camera.project(np.column_stack([places, np.full(200, 0.3)]))
        with np.errstate(invalid="ignore"):
            seen |= ((pixels > 0) & (pixels < camera.lens.size)).all(axis=1)
    assert seen.all()


def test_impossible_ceiling_settings_are_refused():
    with pytest.raises(InputError, match="use more"):
        ceiling_cameras([-20, -20], [20, 20], 4)
    with pytest.raises(InputError):
        ceiling_cameras([0, 0], [1, 1], 0)
    for height in (np.nan, np.inf, 1e30, 0.3, -1.0):
        with pytest.raises(InputError, match="the ceiling must be above"):
            ceiling_cameras([0, 0], [1, 1], height=height)
    with pytest.raises(InputError):
        CeilingOptics(noise=-1)
    with pytest.raises(InputError):
        CeilingOptics(gradient=1.5)
    with pytest.raises(InputError):
        Plate(np.zeros((0, 3), np.float32), 1.0, 1.0)
    for rays in (0, 3, 32):
        with pytest.raises(InputError, match="rays"):
            Plate(np.ones((1, 1), np.float32), 1.0, 1.0, rays)
