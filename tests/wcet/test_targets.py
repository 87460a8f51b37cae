"""Targets and what their budgets allow."""

from __future__ import annotations

from pathlib import Path

import pytest

from servogen.errors import CheckFailed, InputError
from servogen.wcet.allowance import iteration_allowance
from servogen.wcet.operations import CLASSES, OperationCounts
from servogen.wcet.package import Count
from servogen.wcet.targets import (
    COMMON_CLASSES,
    REAL_CLASSES,
    Target,
    bundled_targets,
    load_target,
)


def target_text(add: str = "2", float64: bool = True) -> str:
    def table(name: str, classes: tuple[str, ...]) -> str:
        rows = "".join(f'{c} = {{ value = 1, source = "estimate" }}\n' for c in classes)
        return f"[cycles.{name}]\n{rows}"

    text = (
        'name = "mine"\ndescription = "a board"\n'
        'clock_hz = { value = 1e6, source = "crystal" }\n'
        "[memory]\n"
        'data_bytes = { value = 1000, source = "x" }\n'
        'program_bytes = { value = 10, source = "x" }\n'
    ) + table("common", COMMON_CLASSES)
    text += table("float32", REAL_CLASSES).replace("add = { value = 1", f"add = {{ value = {add}")
    return text + (table("float64", REAL_CLASSES) if float64 else "")


@pytest.fixture
def mine(tmp_path: Path) -> Target:
    (tmp_path / "mine.toml").write_text(target_text(), encoding="utf-8")
    return load_target("mine.toml", tmp_path)


def test_bundled_targets_are_complete() -> None:
    assert {"tms320c6678", "tms320vc33", "f28379d", "cortex_m4f", "cortex_m7", "generic"} <= set(
        bundled_targets()
    )
    for name in bundled_targets():
        target = load_target(name)
        assert target.name == name
        for table in target.cycles.values():
            assert set(table) == set(CLASSES)
            assert all(number.source for number in table.values())


def test_the_paper_s_budget() -> None:
    """20 % of 30 ms on the C6678, which the paper reserves, at the slowest grade's clock."""
    count = Count(OperationCounts(add=1), {}, {}, 0)
    result = iteration_allowance(count, load_target("tms320c6678"), "float64", 0.03, 0.2)
    assert result.budget_cycles == pytest.approx(6.0e6)


def test_a_target_without_the_precision() -> None:
    with pytest.raises(InputError, match=r"output\.precision is float64, expected 'float32'"):
        load_target("tms320vc33").cost(OperationCounts(add=1), "float64")


def test_cost_is_the_weighted_sum(mine: Target) -> None:
    counts = OperationCounts(add=10, mul=3, branch=4)
    assert mine.cost(counts, "float32") == 2 * 10 + 3 + 4
    assert mine.cost(counts, "float64") == 10 + 3 + 4


def count_of(fixed: int, x: int, y: int) -> Count:
    parts = {"X_ITERATION_CAP": OperationCounts(mul=x), "Y_ITERATION_CAP": OperationCounts(mul=y)}
    return Count(OperationCounts(mul=fixed), parts, {n: 10 for n in parts}, 0)


def test_allowance_of_both_axes(mine: Target) -> None:
    result = iteration_allowance(count_of(100, 7, 3), mine, "float64", 1e-3, 0.5)
    assert result.budget_cycles == pytest.approx(500)
    assert (result.fixed_cycles, result.cycles_per_iteration) == (100, 10)
    assert result.total_cycles == 200
    assert result.utilisation == pytest.approx(0.4)
    assert result.largest_cap == 40  # 100 + 40 * 10 = 500 fits just so
    assert result.fits
    result.require()
    assert result.to_json()["largest_cap"] == 40


def test_over_budget_names_the_costlier_loop(mine: Target) -> None:
    result = iteration_allowance(count_of(100, 3, 47), mine, "float64", 1e-3, 0.5)
    assert (result.largest_cap, result.culprit) == (8, "Y_ITERATION_CAP")
    with pytest.raises(CheckFailed, match=r"at most 8 fit; over budget: Y_ITERATION_CAP"):
        result.require()


def test_over_budget_by_the_fixed_part(mine: Target) -> None:
    result = iteration_allowance(count_of(600, 3, 4), mine, "float64", 1e-3, 0.5)
    assert (result.largest_cap, result.culprit) == (0, "fixed part")
    alone = Count(OperationCounts(mul=600), {}, {}, 0)
    result = iteration_allowance(alone, mine, "float64", 1e-3, 0.5)
    assert (result.largest_cap, result.culprit, result.cap) == (None, "fixed part", 0)


def test_the_cap_found_is_the_largest_that_fits(mine: Target) -> None:
    count = count_of(13, 7, 4)
    found = iteration_allowance(count, mine, "float64", 1e-3, 0.5).largest_cap
    assert found is not None
    assert mine.cost(count.total(found), "float64") <= 500
    assert mine.cost(count.total(found + 1), "float64") > 500


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("clock_hz = { value = 1e6", "clock_hz = { value = 0", "clock_hz.value is 0"),
        ("clock_hz = { value = 1e6", "clock_hz = { value = nan", "clock_hz.value is nan"),
        ("clock_hz =", "clock =", "clock is unknown, expected one of name"),
        ('source = "crystal"', 'source = ""', "clock_hz.source is missing"),
        ("sqrt = { value = 1", 'sqrt = { value = "1"', "cycles.float32.sqrt.value is 1, expected"),
        ("sqrt = { value = 1", "sqrt = { value = -1", "cycles.float32.sqrt.value is -1"),
        ("sqrt = { value = 1", "sqrt = { value = true", "cycles.float32.sqrt.value is True"),
        ("call = {", "cal = {", "cycles.common.cal is unknown"),
        ("call = {", "#", "cycles.common.call is missing, expected a table"),
        ("[memory]", "[memo]", "memo is unknown"),
        ('name = "mine"', "name = 3", "name is 3, expected some text"),
        ("[cycles.float32]", "[cycles.float16]", "cycles.float16 is unknown"),
        ("[memory]", "[memory", "expected TOML"),
    ],
)
def test_wrong_target_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = tmp_path / "bad.toml"
    assert old in target_text()
    path.write_text(target_text().replace(old, new), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_target(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_unknown_target(tmp_path: Path) -> None:
    for name in ("pdp11", "none.toml", "../targets/generic"):
        with pytest.raises(InputError, match=r"target\.name is .*, expected one of cortex_m4f"):
            load_target(name, tmp_path)
