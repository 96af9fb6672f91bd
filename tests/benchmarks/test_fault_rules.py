"""The table counts a scan as it is where a rule makes no difference in it."""

from __future__ import annotations

from typing import Any

from benchmarks.fault_rules import (
    FAULTS,
    NAMES,
    OBJECTS,
    RuleJob,
    fault_jobs,
    rows,
    rules_of,
    run_job,
)


def record(name: str, rule: str, worst: float, label: str = "bed") -> dict[str, Any]:
    return {
        "fault": "none", "object": name, "rule": rule, "worst_reliable_m": worst,
        "ate_rmse_m": worst / 2, "ended": "once round the object", "label": label,
        "true_label": "bed", "confident": True,
    }  # fmt: skip


def test_rows_replace_the_scans_that_a_rule_changes() -> None:
    found = [
        record("bed-1", "", 0.02), record("bed-2", "", 0.01),
        record("bed-2", NAMES[0], 0.5, "sofa"),
    ]  # fmt: skip
    whole, changed, same, *_ = rows(found)
    assert whole[2:] == ["7.5, 10", "20", "0", "2", "2", "0"]
    assert changed[1:] == ["1", "130.0, 250", "500", "1", "2", "1", "1"]
    assert same[1] == "0"
    assert same[2:] == whole[2:]


def test_scans_are_of_variants_of_their_own() -> None:
    jobs = fault_jobs(0.5, 4000)
    assert len({job.key for job in jobs}) == len(jobs) == len(OBJECTS) * len(FAULTS)
    assert len(rules_of(NAMES)) == len(NAMES)


def test_a_job_runs_with_all_rules_and_without_one() -> None:
    fault = fault_jobs(0.5, 2)[0]
    whole, part = run_job(RuleJob(fault)), run_job(RuleJob(fault, NAMES[0]))
    assert set(whole["active"]) <= set(NAMES)
    assert (whole["frames"], part["frames"]) == (2, 2)
    assert part["key"] == f"{NAMES[0]}/{fault.key}"
