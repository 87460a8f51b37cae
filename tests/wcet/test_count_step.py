"""What ``servogen wcet`` makes of a package: lines, faults, JSON."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache

import pytest
from core_designs import Variant, design

from servogen.controllers.cascade_design import declare_parts
from servogen.emit.package import CPackage
from servogen.jsontext import json_text
from servogen.steps.count import WcetResult, fit_of, periods_of
from servogen.steps.counted import emit_counted, entry_points
from servogen.wcet.package import PackageCount
from servogen.wcet.targets import Number, Target, bundled_targets, load_target

SMALL = Variant(prefix="small", horizon=3, cap=12, points=10, ramp=3)


@cache
def emitted() -> tuple[CPackage, PackageCount]:
    return emit_counted("small", declare_parts(design(SMALL)))


def result(target: Target, all_targets: bool = False) -> WcetResult:
    package, counts = emitted()
    others = [load_target(name) for name in bundled_targets()] if all_targets else []
    return WcetResult(
        counts,
        fit_of(package, counts, target, 0.2),
        0.2,
        periods_of(package.declarations),
        {t.name: fit_of(package, counts, t, 0.2) for t in others},
    )


def test_every_entry_point_has_a_line() -> None:
    told = result(load_target("tms320c6678"))
    assert told.passed
    lines = told.lines()
    assert lines[0].startswith("wcet      float64 on tms320c6678")
    for name in entry_points(emitted()[0]):
        (line,) = [x for x in lines if x.split()[:1] == [name]]
        numbers = line.split()
        count = told.counts.entry_points[name]
        total = count.total()
        assert [int(n) for n in numbers[1:5]] == [total.add, total.mul, total.div, total.cmp]
        assert sum(int(n) for n in numbers[1:9]) == sum(total.as_dict().values())
        assert int(numbers[9]) == count.stack_bytes
        assert numbers[-1].endswith("%") == (name in told.periods)
    assert len([x for x in lines if "SMALL_MPC_ITERATION_CAP" in x]) == 3
    assert any("small_predict + small_plan + small_start + 10 small_fast_step" in x for x in lines)
    assert all(line in told.lines() for line in replace(told, brief=True).lines())


def test_over_the_cycles() -> None:
    slow = replace(load_target("generic"), clock_hz=Number(1e5, "x"))
    told = result(slow)
    assert not told.passed
    first = told.fit.faults[0]
    assert first.startswith("over the budget of 30 ms by fixed part of small_")
    assert any(line.endswith(f"FAILED: {first}") for line in told.lines())
    assert told.to_json()["faults"] == told.fit.faults
    advised = replace(told, cheaper="fewer points")
    assert advised.lines()[-1].strip() == "what makes it cheaper: fewer points; or target.share"
    fits = replace(result(load_target("tms320c6678")), cheaper="fewer points")
    assert not any("cheaper" in line for line in fits.lines())


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"data_bytes": Number(1000, "x")}, r"data need \d+ of 1000 bytes, most of it small_t"),
        ({"program_bytes": Number(100, "x")}, r"tables need \d+ of 100 bytes, most of it small_"),
    ],
)
def test_over_the_memory(change: dict[str, Number], says: str) -> None:
    told = result(replace(load_target("tms320c6678"), **change))
    assert not told.passed
    (fault,) = told.fit.faults
    assert fault.startswith("tms320c6678 is too small: ")
    assert told.to_json()["passed"] is False
    assert re.search(says, fault), fault


def test_a_dimension_that_the_targets_int_does_not_hold() -> None:
    target = load_target("f28379d")
    assert target.int_bits == 16
    package, counts = emitted()
    assert fit_of(package, counts, target, 0.2).too_large == ()
    narrow = fit_of(package, counts, replace(target, int_bits=6), 0.2)
    assert narrow.faults[-1].endswith("more than an int of 6 bits on f28379d holds")
    largest = max((d.value, d.name) for each in package.declarations for d in each.dimensions)
    assert any(f"{largest[1]} of small" in f and f"is {largest[0]}," in f for f in narrow.faults)


def test_all_targets_are_told_also_those_that_cannot() -> None:
    told = result(load_target("tms320c6678"), all_targets=True)
    text = "\n".join(told.lines())
    for name in bundled_targets():
        assert f"          {name} " in text
    assert "tms320vc33 has no cycles for float64, only for float32" in text
    assert told.passed  # the others do not decide
    data = json.loads(json_text(told.to_json()))
    assert set(data["targets"]) == set(bundled_targets())
    assert data["targets"]["tms320vc33"]["budgets"] == {}
    assert data["targets"]["tms320vc33"]["passed"] is False
    assert data["budgets"]["30 ms"]["calls"]["small_fast_step"] == 10
    assert data["budgets"]["3 ms"]["calls"] == {"small_start": 1, "small_fast_step": 1}


def test_memory_is_what_the_caller_holds() -> None:
    package, counts = emitted()
    memory = fit_of(package, counts, load_target("generic"), 0.2).memory
    assert set(memory.state) == {"small_t"}  # the parts are inside
    assert set(memory.arguments) == {
        f"small_{name}"
        for name in ("predict_in", "predict_out", "plan_in", "plan_out", "start_out",
                     "fast_step_out")
    }  # fmt: skip
    assert len(memory.stack) == 2
    assert memory.table_bytes == sum(d.table_bytes for d in package.declarations)
