"""The check of the counts on a small cascade: it passes, and sees each way of counting wrongly."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest
from core_designs import Variant, design

from servogen.controllers.cascade_design import declare_parts
from servogen.evidence import counts as check
from servogen.evidence.bench import Bench, Subject
from servogen.evidence.counts_run import Runs, count_runs, entry_names
from servogen.precision import FLOAT64
from servogen.progress import Silent
from servogen.sil.player import Play
from servogen.sil.scenarios import suite
from servogen.steps.counted import emit_counted
from servogen.wcet.operations import OperationCounts
from servogen.wcet.package import Count

SMALL = Variant(prefix="small", horizon=3, cap=12, points=10, ramp=3)
STEPS = 12


@cache
def plays() -> tuple[Play, ...]:
    cases = suite(design(SMALL), 5, STEPS)
    return tuple(Play(c.name, c.reference().declaration.prefix, tuple(c.calls)) for c in cases)


@cache
def subject() -> Subject:
    package, counts = emit_counted("small", declare_parts(design(SMALL)))
    return Subject(
        package, FLOAT64, counts, lambda _: list(plays()[:-1]), lambda _: list(plays()[-1:])
    )


@cache
def honest() -> Runs:
    return count_runs(subject(), plays())


def less(part: OperationCounts, name: str, number: int) -> OperationCounts:
    return part + OperationCounts(**{name: -number})


def quarter_off(count: Count) -> Count:
    (cap,) = count.per_iteration
    part = count.per_iteration[cap]
    return replace(count, per_iteration={cap: less(part, "mul", part.mul // 4)})


WRONG: dict[str, Callable[[Count], Count]] = {
    # an operation too few in the fixed part
    "small_governor_step": lambda c: replace(c, fixed=less(c.fixed, "cmp", 1)),
    # too few in a turn: as long as the cap is not reached, the total would hide it
    "small_mpc_step": quarter_off,
    # more than every run does
    "small_mpc_candidate": lambda c: replace(c, fixed=less(c.fixed, "mul", -1)),
    "small_init": lambda c: replace(c, fixed=less(c.fixed, "store", 1)),
}


@cache
def faults() -> tuple[str, ...]:
    """What is found when all of these are miscounted."""
    counts = subject().counts
    entries = {n: WRONG.get(n, lambda c: c)(c) for n, c in counts.entry_points.items()}
    wrong = replace(subject(), counts=replace(counts, entry_points=entries))
    return tuple(check.judge(wrong, plays(), count_runs(wrong, plays())))


@pytest.fixture(autouse=True)
def few_calls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check, "RANDOM_CALLS", 50)


def test_the_emitted_c_keeps_to_its_counts() -> None:
    finding = check.run(Bench("small", (subject(),)), Silent())
    assert finding.faults == ()
    assert finding.passed
    figures = finding.figures["float64"]
    assert figures["random_calls"] >= 50
    assert set(figures["entry_points"]) == set(entry_names(subject()))
    assert figures["bounds_seen_turn_by_turn"] == ["SMALL_MPC_ITERATION_CAP"]
    entries = figures["entry_points"]
    assert {name for name, e in entries.items() if e["equal"]} >= {
        "small_init", "small_mpc_init", "small_mpc_candidate", "small_mpc_hold",
    }  # fmt: skip
    for e in entries.values():
        assert all(e["largest_run"][c] <= e["static"][c] for c in e["static"])
        assert all(e["largest_run"][c] == e["static"][c] for c in e["same_in_every_run"])
    step = entries["small_mpc_step"]
    assert step["most_turns"] == step["caps"] == {"SMALL_MPC_ITERATION_CAP": 12}
    assert step["ratio_of_turns_done"] > 0.8
    assert "always equal" in finding.summary
    assert check._figures(subject(), plays(), honest()) == figures  # another build of the twin


def test_calls_are_those_that_were_played() -> None:
    total = sum(times for play in plays() for _, times in play.counted())
    inits = len(subject().package.declarations) * (len(plays()) + 1)
    assert sum(entry.calls for entry in honest().entries.values()) == total + inits


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ("small_governor_step", r"\d+ cmp in call \d+ of '.*' where \d+ are, counted at most"),
        ("small_mpc_step", r"\d+ mul in call \d+ of '.*' where \d+ are, counted at most"),
        ("small_mpc_candidate", r"\d+ mul in call 1 of .* where \d+ are, counted for every run"),
        ("small_init", r"\d+ store in .* where \d+ are, counted at most"),
    ],
)
def test_a_miscount_is_found_and_named(entry: str, says: str) -> None:
    (fault,) = [f for f in faults() if f.startswith(f"{entry}: ")]
    assert re.search(says, fault), fault


def test_nothing_else_is_found() -> None:
    assert len(faults()) == len(WRONG)


def test_an_entry_point_that_is_never_called_has_not_been_checked() -> None:
    entries = dict(honest().entries)
    entries["small_mpc_hold"] = replace(entries["small_mpc_hold"], calls=0)
    told = check.judge(subject(), plays(), Runs(entries, honest().watched))
    assert told == ["small_mpc_hold was never called"]


def test_more_turns_than_the_bound_are_found() -> None:
    entries = dict(honest().entries)
    step = entries["small_mpc_step"]
    entries["small_mpc_step"] = replace(step, largest=step.largest + OperationCounts(mul=10**6))
    told = check.judge(subject(), plays(), Runs(entries, honest().watched))
    assert told == ["small_mpc_step does more turns of a loop than its bound"]


def test_too_few_random_calls_are_no_check(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check, "RANDOM_CALLS", 10_000)
    assert any("random calls where 10000" in f for f in check.judge(subject(), plays(), honest()))


def test_the_place_of_a_call() -> None:
    first, second = plays()[:2]
    assert check._place(0, plays()) == f"call 0 of '{first.name}'"
    assert check._place(len(first.calls) + 2, plays()) == f"call 2 of '{second.name}'"
