"""Switching a rule off replaces its functions, and only within the context."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from benchmarks import ablation
from benchmarks.ablation import ALL, NONE, VARIANTS, AblationJob, cells, results, row, run
from benchmarks.ablation_data import Source
from benchmarks.ablation_rules import RULES
from benchmarks.open_loop import run_open_loop
from benchmarks.open_loop_trackers import GicpWithOdometry, KernelOnly, OwnTracker, WheelsOnly
from benchmarks.rule_patches import Patch, Rule, probed, without
from scipy.spatial.transform import RigidTransform
from tests.tracking_world import SETTINGS, SHORT, short_drive, true_camera

from circumspect.errors import InputError

TRUTH = RigidTransform.concatenate([true_camera(float(angle)) for angle in SHORT])


class Half:
    def of(self, number: float) -> float:
        return number / 2

    @property
    def whole(self) -> float:
        return 1.0


def poses(rules: tuple[Rule, ...] = ()) -> np.ndarray:
    tracker = OwnTracker(SETTINGS)
    with without(rules):
        live = [tracker.track(frame).T_map_camera for frame in short_drive()]
        return np.concatenate([live, tracker.finalise()])


@pytest.fixture(scope="module")
def active() -> set[str]:
    with probed(RULES) as names:
        poses()
    return names


def test_rule_names_are_unique() -> None:
    assert len({rule.name for rule in RULES}) == len(RULES)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_rule_is_off_only_within_the_context(rule: Rule) -> None:
    before = [getattr(one.owner, one.name) for one in rule.patches]
    with without([rule]):
        for one in rule.patches:
            assert getattr(one.owner, one.name) is one.neutral
    assert [getattr(one.owner, one.name) for one in rule.patches] == before


def test_neutral_version_is_called() -> None:
    rule = Rule("half", "", (Patch(Half, "of", lambda _, number: number),))
    with without([rule]):
        assert Half().of(3.0) == 3.0
    assert Half().of(3.0) == 1.5


def test_probe_finds_rules_that_make_a_difference() -> None:
    idle = Rule("idle", "", (Patch(Half, "of", lambda _, number: 0.5 * number, True),))
    other = Rule("other", "", (Patch(Half, "of", lambda *_: 1.0, True),))
    impure = Rule("impure", "", (Patch(Half, "of", lambda *_: 1.5),))
    with probed([idle, other, impure]) as names:
        assert not names
        assert Half().of(3.0) == 1.5
        assert names == {"other", "impure"}


def test_probe_reads_properties() -> None:
    other = Rule("other", "", (Patch(Half, "whole", property(lambda _: 2.0), True),))
    same = Rule("same", "", (Patch(Half, "whole", property(lambda _: 1.0), True),))
    with probed([other, same]) as names:
        assert Half().whole == 1.0
        assert names == {"other"}
    with without([other]):
        assert Half().whole == 2.0
    assert Half().whole == 1.0


def test_levelness_makes_a_difference(active: set[str]) -> None:
    assert "levelness" in active
    rule = next(rule for rule in RULES if rule.name == "levelness")
    assert not np.array_equal(poses((rule,)), poses())


def test_rules_that_make_no_difference_change_no_pose(active: set[str]) -> None:
    idle = tuple(rule for rule in RULES if rule.name not in active)
    assert len(idle) >= 5
    reference = poses()
    for rule in idle:
        np.testing.assert_array_equal(poses((rule,)), reference, rule.name)


def test_tracker_runs_without_any_rule() -> None:
    with without(RULES):
        found = run_open_loop(OwnTracker(SETTINGS), short_drive(), TRUTH)
    assert found.reliable == 1.0


@pytest.mark.parametrize(
    ("baseline", "limit_mm"), [(WheelsOnly, 30.0), (GicpWithOdometry, 10.0), (KernelOnly, 10.0)]
)
def test_baseline_follows_a_short_drive(baseline: type, limit_mm: float) -> None:
    found = run_open_loop(baseline(SETTINGS), short_drive(), TRUTH)
    assert found.ate_mm < limit_mm
    assert found.final_ate_mm == found.ate_mm


def test_dead_reckoning_needs_odometry() -> None:
    frames = [replace(frame, odometry=None) for frame in short_drive()]
    with pytest.raises(InputError, match="no odometry"):
        run_open_loop(WheelsOnly(SETTINGS), frames, TRUTH)


def record(variant: str, ate: float, active: tuple[str, ...] = ()) -> dict:
    return {
        "source": "robot_kidnapped.sofa/all/1", "variant": variant, "active": list(active),
        "ate_mm": ate, "final_ate_mm": ate, "worst_reliable_mm": None, "nees": 123456.0,
        "worst_reliable_sigmas": None, "reliable": 0.5, "recovered": True, "frames": 9,
    }  # fmt: skip


def test_record_names_the_rules_that_make_a_difference(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "none.box.npz"
    path.write_bytes(b"1")
    source = Source("furniture", path)
    monkeypatch.setattr(ablation, "loaded", lambda _: (short_drive()[:4], TRUTH[:4]))
    full = run(AblationJob(ALL, source))
    assert "levelness" in full["active"]
    for variant in (RULES[0].name, NONE, "wheels only"):
        found = run(AblationJob(variant, source))
        assert found["frames"] == 4
        assert "active" not in found
    assert "active" not in run(AblationJob(ALL, source, timed=True))


def test_idle_rules_have_the_results_of_all_rules(tmp_path: Path) -> None:
    path = tmp_path / "robot_kidnapped.sofa.npz"
    path.write_bytes(b"1")
    acting = RULES[0].name
    some = [record(ALL, 2.0, (acting,)), record(acting, 3.0)]
    rest = [record(variant, 9.0) for variant in VARIANTS if variant not in {r.name for r in RULES}]
    source = Source("faults", path)
    assert not results(some, [source])
    found = results([*rest[1:], *some], [source])[source.key]
    assert set(found) == set(VARIANTS)
    assert found[RULES[1].name]["ate_mm"] == 2.0
    line = cells(row(acting, [found]))
    assert line == [acting, "3.0", "3.0", "3.0", "–", "–", "1e5", "50%", "1/1", "1/1", "1/1"]
    assert cells(row(RULES[1].name, [found]))[-1] == "0/1"
