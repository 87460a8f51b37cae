"""A failed simulation says which check failed, with value and limit."""

from __future__ import annotations

from dataclasses import replace

from servogen.reports import ReportData
from servogen.steps.two_stage_run import SimulateResult


def result(data: ReportData, limit_m: float = 1.0, **changes: object) -> SimulateResult:
    row = replace(data.row, **changes)  # type: ignore[arg-type]
    return SimulateResult(data.run, row, "compiled C", limit_m)


def test_a_good_run_has_no_fault(bare: ReportData) -> None:
    good = result(bare)
    assert good.passed
    assert good.faults == []
    assert not any("FAILED" in line for line in good.lines())


def test_every_failed_check_is_a_line(bare: ReportData) -> None:
    over = tuple(replace(b, worst=2.0 * b.limit) for b in bare.row.bounds)
    bad = result(
        bare,
        limit_m=1e-12,
        complete=False,
        followed=False,
        bounds=over,
        statuses={"BACKUP": bare.row.periods},
    )
    enforced = sum(b.enforced for b in over)
    assert not bad.passed
    assert len(bad.faults) == 4 + enforced
    assert sum("FAILED: " in line for line in bad.lines()) == len(bad.faults)
    for words in ("not finished", "skipped points", "contour error", "backups on 50.0%"):
        assert any(words in fault for fault in bad.faults)
    assert bad.to_json()["faults"] == bad.faults


def test_a_reference_that_leaves_the_path_is_seen(bare: ReportData) -> None:
    from servogen.systems.metrics import follows_path

    run = bare.run
    assert follows_path(run)
    moved = run.reference.copy()
    moved[len(moved) // 2, 0] += 1e-5
    assert not follows_path(replace(run, reference=moved))
    jumped = run.along.copy()
    jumped[len(jumped) // 2 :] += 2.0
    assert not follows_path(replace(run, along=jumped))
    assert not follows_path(replace(run, along=run.along[::-1].copy()))
