"""What the budgets of a target allow, in cycles and in bytes."""

from __future__ import annotations

from dataclasses import replace

import pytest

from servogen.errors import CheckFailed
from servogen.wcet.allowance import Allowance, Task, allowance, allowances
from servogen.wcet.memory import Memory, occupied
from servogen.wcet.operations import CLASSES, OperationCounts
from servogen.wcet.package import Count
from servogen.wcet.targets import Number, Target, load_target

ONE = {name: Number(1.0, "x") for name in CLASSES}
MINE = Target("mine", "a board", *(Number(v, "x") for v in (1e6, 1000.0, 800.0)), {"float64": ONE})


def count_of(fixed: int, x: int = 0, y: int = 0, stack: int = 0) -> Count:
    parts = {"X_ITERATION_CAP": OperationCounts(mul=x), "Y_ITERATION_CAP": OperationCounts(mul=y)}
    parts = {name: part for name, part in parts.items() if part.mul}
    return Count(OperationCounts(mul=fixed), parts, dict.fromkeys(parts, 10), stack)


def alone(count: Count) -> Allowance:
    """Budget of 500 cycles."""
    return allowance({"f": (count, 1)}, MINE, "float64", 1e-3, 0.5)


def test_the_paper_s_budget() -> None:
    """20 % of 30 ms on the C6678, which the paper reserves, at the slowest grade's clock."""
    target = load_target("tms320c6678")
    result = allowance({"f": (count_of(1), 1)}, target, "float64", 0.03, 0.2)
    assert result.budget_cycles == pytest.approx(6.0e6)


def test_allowance_of_both_axes() -> None:
    result = alone(count_of(100, 7, 3))
    assert result.budget_cycles == pytest.approx(500)
    assert (result.fixed_cycles, result.cycles_per_iteration) == (100, 10)
    assert result.total_cycles == 200
    assert result.utilisation == pytest.approx(0.4)
    assert result.largest_cap == 40  # 100 + 40 * 10 = 500 fits just so
    assert result.fits
    result.require()
    assert result.to_json()["largest_cap"] == 40


def test_over_budget_names_the_costlier_loop() -> None:
    result = alone(count_of(100, 3, 47))
    assert (result.largest_cap, result.culprit) == (8, "Y_ITERATION_CAP")
    with pytest.raises(CheckFailed, match=r"1 ms .*at most 8 fit; over budget: Y_ITERATION_CAP"):
        result.require()


def test_over_budget_by_the_fixed_part() -> None:
    result = alone(count_of(600, 3, 4))
    assert (result.largest_cap, result.culprit) == (0, "fixed part of f")
    result = alone(count_of(600))
    assert (result.largest_cap, result.culprit, result.cap) == (None, "fixed part of f", 0)


def test_the_cap_found_is_the_largest_that_fits() -> None:
    count = count_of(13, 7, 4)
    found = alone(count).largest_cap
    assert found is not None
    assert MINE.cost(count.total(found), "float64") <= 500
    assert MINE.cost(count.total(found + 1), "float64") > 500


def test_levels_of_a_tree_belong_to_the_fixed_part() -> None:
    tree = {"T_TREE_DEPTH": OperationCounts(mul=30)}
    count = count_of(100, 10)
    count = replace(count, per_level=tree, caps={**count.caps, "T_TREE_DEPTH": 4})
    result = alone(count)
    assert (result.fixed_cycles, result.total_cycles, result.cap) == (220, 320, 10)
    assert result.largest_cap == 28
    assert count.total(1).mul == 230


def tasks(plan: int = 100, tick: int = 3) -> list[Task]:
    """A slow part, a short one that must be done at once, and one ten times as often."""
    return [
        Task("plan", count_of(plan, 2, stack=700), 1e-3, 1e-3),
        Task("start", count_of(5, stack=80), 1e-3, 1e-4),
        Task("tick", count_of(tick, stack=90), 1e-4, 1e-4),
    ]


def test_a_window_holds_all_that_has_to_be_done_in_it() -> None:
    slow, fast = allowances(tasks(), MINE, "float64", 0.5)
    assert (slow.label, fast.label) == ("1 ms", "0.1 ms")
    assert slow.calls == {"plan": 1, "start": 1, "tick": 10}
    assert slow.cycles == {"plan": 120, "start": 5, "tick": 30}
    assert (slow.budget_cycles, slow.total_cycles, slow.fixed_cycles) == (500, 155, 135)
    assert slow.largest_cap == (500 - 135) // 2
    assert fast.calls == {"start": 1, "tick": 1}
    assert (fast.total_cycles, fast.budget_cycles, fast.largest_cap) == (8, 50, None)


def test_many_small_calls_may_break_the_long_budget() -> None:
    slow, fast = allowances(tasks(tick=42), MINE, "float64", 0.5)
    assert fast.fits
    assert not slow.fits
    assert slow.culprit == "fixed part of tick"
    assert slow.total_cycles == 120 + 5 + 420


@pytest.mark.parametrize(("period", "times"), [(0.03 / 150, 150), (0.007, 5), (0.03, 1)])
def test_calls_that_fall_into_a_window(period: float, times: int) -> None:
    both = [Task("long", count_of(1), 0.03, 0.03), Task("short", count_of(1), period, period)]
    assert allowances(both, MINE, "float64", 0.5)[0].calls["short"] == times


def memory(target: Target = MINE, tables: int = 500) -> Memory:
    return occupied(tasks(), {"p_t": 60}, {"p_in": 40}, {"t": tables, "u": 100}, target)


def test_an_interrupt_adds_its_stack() -> None:
    found = memory()
    assert found.stack == {"plan": 700, "tick": 90}
    assert (found.data_bytes, found.table_bytes, found.fits) == (60 + 40 + 790, 600, True)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (
            {"data_bytes": Number(889, "x")},
            "data need 890 of 889 bytes, most of it stack of plan (700 bytes)",
        ),
        (
            {"program_bytes": Number(599, "x")},
            "tables need 600 of 599 bytes, most of it t (500 bytes)",
        ),
        (
            {"together_bytes": Number(1400, "x")},
            "data and tables need 1490 of 1400 bytes, most of it stack of plan (700 bytes)",
        ),
    ],
)
def test_memory_that_is_too_small(change: dict[str, Number], says: str) -> None:
    found = memory(replace(MINE, **change))
    assert found.faults() == [says]
    assert found.to_json()["fits"] is False
